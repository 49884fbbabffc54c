/// The client library without a cell.

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "services/client/connection.hpp"
#include "services/client/convert.hpp"
#include "services/config/cell_file.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::client {
namespace {

constexpr double kHalf = std::numbers::sqrt2 / 2.0;

void expect_rotation(const Pose& pose, const std::array<double, 4>& wxyz) {
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(pose.rotation[i], wxyz[i], 1e-15) << i;
}

TEST(PublicPose, RotatesAboutFixedAxesInTheOrderOfUrdf) {
  constexpr double kRight = std::numbers::pi / 2.0;
  expect_rotation(Pose::xyz(1.0, 2.0, 3.0), {1.0, 0.0, 0.0, 0.0});
  expect_rotation(Pose::xyz_rpy(0.0, 0.0, 0.0, kRight, 0.0, 0.0), {kHalf, kHalf, 0.0, 0.0});
  expect_rotation(Pose::xyz_rpy(0.0, 0.0, 0.0, 0.0, kRight, 0.0), {kHalf, 0.0, kHalf, 0.0});
  expect_rotation(Pose::xyz_rpy(0.0, 0.0, 0.0, 0.0, 0.0, kRight), {kHalf, 0.0, 0.0, kHalf});
  // q = q_yaw · q_roll: the roll is applied first.
  expect_rotation(Pose::xyz_rpy(0.0, 0.0, 0.0, kRight, 0.0, kRight), {0.5, 0.5, 0.5, 0.5});
  expect_rotation(to_public(to_message(Pose::xyz_rpy(0.0, 0.0, 0.0, kRight, 0.0, kRight))), {0.5, 0.5, 0.5, 0.5});
}

TEST(PublicEnumerations, HaveTheValuesAndNamesOfTheMessages) {
  EXPECT_EQ(static_cast<std::uint32_t>(GoalState::kTimedOut),
            static_cast<std::uint32_t>(msg::GoalState::GOAL_TIMED_OUT));
  EXPECT_EQ(static_cast<std::uint32_t>(CauseKind::kContact), static_cast<std::uint32_t>(msg::CauseKind::CAUSE_CONTACT));
  EXPECT_EQ(static_cast<std::uint32_t>(FreeRotation::kAll), static_cast<std::uint32_t>(msg::FreeRotation::FREE_ALL));
  EXPECT_EQ(name_of(GoalState::kTimedOut), "timed_out");
  EXPECT_EQ(name_of(FreeRotation::kYaw), "yaw");
  EXPECT_EQ(name_of(CauseKind::kNone), "none");
  EXPECT_EQ(name_of(static_cast<ArmMode>(999)), "unknown");
}

TEST(PublicObstacle, ConvertsFullSizesToHalfSizes) {
  const msg::Obstacle box = to_message("crate", Box{0.2, 0.4, 0.6}, Pose::xyz(1.0, 2.0, 3.0), Static{});
  ASSERT_EQ(box.shapes().size(), 1U);
  EXPECT_EQ(box.shapes()[0].kind(), msg::ShapeKind::SHAPE_BOX);
  EXPECT_DOUBLE_EQ(box.shapes()[0].dimensions().z(), 0.3);
  EXPECT_EQ(box.X_WO().position().y(), 2.0);
  EXPECT_EQ(box.motion().kind(), msg::MotionKind::MOTION_STATIC);
  const msg::Obstacle can = to_message("can", Cylinder{0.1, 0.5}, Pose{}, Conveyor{{0.0, -3.0, 4.0}, 2.0});
  EXPECT_DOUBLE_EQ(can.shapes()[0].dimensions().y(), 0.25);
  EXPECT_DOUBLE_EQ(can.motion().speed(), 5.0);
  EXPECT_DOUBLE_EQ(can.motion().direction_W().z(), 0.8);
}

TEST(PublicObstacle, ConvertsPointsToTheirConvexHull) {
  // The corners of a cube, and its centre, which is no vertex of the hull.
  ConvexHull cube{{{0.5, 0.5, 0.5}}};
  for (const double x : {0.0, 1.0}) {
    for (const double y : {0.0, 1.0}) {
      for (const double z : {0.0, 1.0}) cube.points.push_back({x, y, z});
    }
  }
  const msg::Obstacle obstacle = to_message("part", cube, Pose{}, Static{});
  ASSERT_EQ(obstacle.shapes().size(), 1U);
  EXPECT_EQ(obstacle.shapes()[0].kind(), msg::ShapeKind::SHAPE_CONVEX);
  EXPECT_EQ(obstacle.shapes()[0].vertices().size(), 8U);
  EXPECT_EQ(obstacle.shapes()[0].face_sizes().size(), 6U);
  EXPECT_THROW(static_cast<void>(to_message("flat", ConvexHull{{{}, {1.0}, {0.0, 1.0}, {1.0, 1.0}}}, Pose{}, Static{})),
               InvalidArgument);
}

TEST(PublicObstacle, ConvertsPoints) {
  const Points cloud{{{0.5, 0.0, 1.0}, {0.25, 0.0, 1.0}}, 0.01};
  const msg::Obstacle obstacle = to_message("scan", cloud, Pose{}, Static{});
  ASSERT_EQ(obstacle.shapes().size(), 1U);
  EXPECT_EQ(obstacle.shapes()[0].kind(), msg::ShapeKind::SHAPE_POINTS);
  EXPECT_EQ(obstacle.shapes()[0].dimensions().x(), 0.01);
  EXPECT_EQ(obstacle.shapes()[0].points(), (std::vector<double>{0.25, 0.0, 1.0, 0.5, 0.0, 1.0}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Points& bad :
       {Points{{}, 0.01}, Points{{{nan}}, 0.01}, Points{{{}}, 0.0}, Points{std::vector<Vector3>(100'001), 0.01}}) {
    EXPECT_THROW(static_cast<void>(to_message("scan", bad, Pose{}, Static{})), InvalidArgument);
  }
}

TEST(PublicProgress, HasTheMeasuredErrorOfTheToolAndTheNearestOrientation) {
  msg::GoalStatus status;
  EXPECT_FALSE(to_public(status).tool_error);
  EXPECT_FALSE(to_public(status).nearest);
  status.has_tool(true);
  status.position_error(-1.0);
  EXPECT_FALSE(to_public(status).tool_error) << "not measured";
  status.position_error(0.001);
  status.orientation_error(0.02);
  EXPECT_EQ(to_public(status).tool_error.value().orientation, 0.02);
  status.has_nearest(true);
  status.nearest_angle(0.8);
  status.X_WT_nearest().position().x(0.4);
  EXPECT_EQ(to_public(status).nearest.value().angle, 0.8);
  EXPECT_EQ(to_public(status).nearest->pose.position.x, 0.4);
  status.note("joint x becomes 3");
  EXPECT_EQ(to_public(status).note, "joint x becomes 3");
}

TEST(Outcome, HasStateCauseAndBindingPair) {
  EXPECT_FALSE(Outcome{});
  EXPECT_NE(Outcome{}.text().find("unanswered"), std::string::npos);
  Progress progress;
  progress.state = GoalState::kBlocked;
  progress.cause = {CauseKind::kPathBlocked, "pallet", "no path around pallet"};
  progress.binding = {"west/forearm", "pallet", 0.018};
  const Outcome blocked{OutcomeKind::kBlocked, progress};
  EXPECT_FALSE(blocked);
  EXPECT_EQ(blocked.text(), "blocked: no path around pallet (west/forearm – pallet)");
  EXPECT_EQ(blocked.cause().kind, CauseKind::kPathBlocked);
  EXPECT_EQ((Outcome{OutcomeKind::kInterrupted, std::nullopt}.text()), "interrupted");
}

TEST(Outcome, SaysForHowLongNoPlannerHasAnswered) {
  msg::GoalStatus status;
  status.state(msg::GoalState::GOAL_ACTIVE);
  status.cause().kind(msg::CauseKind::CAUSE_PATH_BLOCKED);
  status.cause().text("the arm is stopped");
  EXPECT_EQ(to_public(status).age, Seconds::zero());
  EXPECT_EQ((Outcome{OutcomeKind::kActive, to_public(status, Seconds(0.4))}.text()), "active: the arm is stopped");
  EXPECT_EQ((Outcome{OutcomeKind::kActive, to_public(status, Seconds(12.2))}.text()),
            "no planner of the arm has answered for 12 s; the goal was active: the arm is stopped");
  status.state(msg::GoalState::GOAL_CANCELLED);
  EXPECT_EQ((Outcome{OutcomeKind::kCancelled, to_public(status, Seconds(12.2))}.text()),
            "cancelled: the arm is stopped");
}

TEST(Deadline, IsFiniteForEveryLimit) {
  const auto now = Clock::now();
  EXPECT_GT(deadline_of(kForever), now + std::chrono::hours(24));
  for (const double limit : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    const auto deadline = deadline_of(Seconds(limit));
    EXPECT_LE(deadline, Clock::now()) << limit;
  }
}

TEST(Connect, RejectsAMissingFile) {
  EXPECT_THROW(static_cast<void>(Cell::connect("/nonexistent.yaml")), InvalidArgument);
}

TEST(Connect, RejectsADomainOutsideItsRangeWithBoth) {
  for (const int domain : {-1, 200, 500}) {
    try {
      static_cast<void>(Cell::connect({std::nullopt, domain}));
      ADD_FAILURE() << domain;
    } catch (const InvalidArgument& error) {
      EXPECT_EQ(std::string(error.what()),
                "domain = " + std::to_string(domain) + " must be a whole number from 0 to 199");
    }
  }
}

TEST(GoalsWithoutAPlanner, AreForgottenWhenNobodyHoldsThem) {
  const test::FreeDomain domain;
  const auto connection = Connection::make(
      join(config::load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml"), domain.number()));
  const auto send = [&] {
    msg::Goal goal;
    goal.arm("north");
    goal.kind(msg::GoalKind::GOAL_NAMED);
    goal.named("home");
    return connection->send(goal);
  };
  const auto held = send();
  for (int i = 0; i < 300; ++i) static_cast<void>(send());
  EXPECT_EQ(connection->open_goals(), 301U);
  EXPECT_TRUE(connection->wait_until([&] { return connection->open_goals() == 1; }, {std::chrono::seconds(100), {}}));
  EXPECT_FALSE(connection->status_of(*held));
}

TEST(NamesWithANul, AreRefusedBecauseReceiversReadAnotherName) {
  const test::FreeDomain domain;
  const auto connection = Connection::make(
      join(config::load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml"), domain.number()));
  msg::Goal goal;
  goal.arm("north");
  goal.kind(msg::GoalKind::GOAL_NAMED);
  goal.named(std::string("home\0xx", 7));
  EXPECT_THROW(static_cast<void>(connection->send(goal)), InvalidArgument);
  goal.named("home");
  EXPECT_NO_THROW(static_cast<void>(connection->send(goal)));
}

}  // namespace
}  // namespace hecaton::client
