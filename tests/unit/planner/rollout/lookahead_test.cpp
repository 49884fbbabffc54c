// A ram pushes the point against a wall. Reaction alone ends in a contact; lookahead avoids it.
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "planner/rollout/rollout_policy.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::box_obstacle;
using test::joints;

constexpr double kPeriod = 0.01;
constexpr double kRadius = 0.05;
const Eigen::Vector3d kRamHalf(0.05, 0.15, 0.1);

/// The point at (0, 0), a wall 0.1 m behind it, and a ram that approaches at 0.4 m/s from the other side. Its face is
/// flat, so that no small motion increases the distance.
class Ram : public testing::Test {
 protected:
  Ram() {
    boxes_ = {box_obstacle("wall", {0.25, 0, 0}, {0.1, 0.6, 0.1}), box_obstacle("ram", {-1, 0, 0}, kRamHalf)};
    for (const auto& box : boxes_) states_.push_back({box.X_WO, {}, 0.0});
    states_[1].velocity.linear = {0.4, 0, 0};
  }

  /// The least distance between point and ram until the ram reaches the wall [m].
  double least_distance(const std::optional<JointVector>& goal) {
    ArmController controller(CellGeometry({test::planar_point()}, 0), parameters_, kPeriod, 1);
    controller.set_obstacles(boxes_);
    if (goal) controller.set_goal(*goal);
    RolloutPolicy policy(parameters_, 1);
    RolloutSearch search({test::planar_point()}, {parameters_}, 0);
    search.set_obstacles(boxes_);
    const std::array<ArmObservation, 1> no_arms{};
    MeasuredState at{joints({0, 0}), joints({0, 0})};
    double least = 10.0;
    while (states_[1].X_WO.translation().x() < 0.08) {
      if (const auto time = policy.rollout_wait()) controller.wait_for_rollout(*time);
      const TickResult result = controller.step(at, no_arms, states_, false);
      at = {result.q, result.qd};
      if (auto question = policy.next(controller, result, no_arms, states_)) {
        search.begin(std::move(*question));
      } else if (const auto answer = search.advance(parameters_.rollout.ticks_per_period)) {
        policy.answered();
        controller.begin(answer->manoeuvre);
      }
      states_[1].X_WO = world::extrapolate(states_[1].X_WO, states_[1].velocity, kPeriod);
      const Eigen::Vector3d p(at.q[0], at.q[1], 0.0);
      least =
          std::min(least, ((p - states_[1].X_WO.translation()).cwiseAbs() - kRamHalf).cwiseMax(0.0).norm() - kRadius);
    }
    return least;
  }

  LocalParameters parameters_;
  std::vector<world::Obstacle> boxes_;
  std::vector<world::ObstacleState> states_;
};

TEST_F(Ram, HitsAnArmThatOnlyReacts) {
  parameters_.rollout.candidates = 0;
  EXPECT_LT(least_distance({}), 0.0);
}

TEST_F(Ram, MissesAnArmWithoutGoalThatLooksAhead) {
  EXPECT_GT(least_distance({}), 0.01);
}

TEST_F(Ram, MissesAnArmAtItsGoalThatLooksAhead) {
  EXPECT_GT(least_distance(joints({0, 0})), 0.01);
}

TEST_F(Ram, MissesAMovingArmThatLooksAhead) {
  EXPECT_GT(least_distance(joints({0.05, 0.5})), 0.01);
}

/// The same scene as a question to the search.
class Lookahead : public Ram {
 protected:
  Lookahead() : search_({test::planar_point()}, {parameters_}, 0) {
    search_.set_obstacles(boxes_);
    states_[1].X_WO.translation().x() = -0.5;  // it arrives within the look
    RolloutArm arm;
    arm.q = arm.qd = joints({0, 0});
    arm.plans = true;
    question_.arms = {arm};
    question_.horizon = kLookaheadTime;
    question_.candidates = 16;
    question_.lookahead = true;
  }

  RolloutAnswer answer(int ticks_at_a_time) {
    question_.obstacles = states_;
    search_.begin(question_);
    for (int calls = 0; calls < 100'000; ++calls) {
      if (const auto found = search_.advance(ticks_at_a_time)) return *found;
    }
    ADD_FAILURE() << "no answer";
    return {};
  }

  RolloutSearch search_;
  RolloutQuestion question_;
};

TEST_F(Lookahead, EscapeKeepsItsPredictedMargin) {
  const RolloutAnswer found = answer(1'000'000);
  ASSERT_EQ(found.manoeuvre.kind, ManoeuvreKind::kEvade);
  EXPECT_LT(found.cost, found.cost_of_continuing);

  const auto room_after = [&](const Manoeuvre& manoeuvre) {
    RolloutSimulation cell({test::planar_point()}, {parameters_}, 0.025);
    cell.set_obstacles(boxes_);
    auto arms = question_.arms;
    begin(manoeuvre, arms[0].memory);
    cell.begin(arms, states_);
    while (cell.time() < kLookaheadTime) cell.step();
    return cell.clearance_margin(0);
  };
  const double security = parameters_.damper.security_distance;
  EXPECT_LT(room_after({}), -security) << "a contact";
  EXPECT_GT(room_after(found.manoeuvre), -0.5 * security);
}

TEST_F(Lookahead, AnswerIsIndependentOfInterruptions) {
  const RolloutAnswer whole = answer(1'000'000);
  const RolloutAnswer in_pieces = answer(1);
  EXPECT_EQ(whole.manoeuvre.q, in_pieces.manoeuvre.q);
  EXPECT_EQ(whole.cost, in_pieces.cost);
}

TEST_F(Lookahead, SimulatesNoEscapeWhenContinuingIsSafe) {
  states_[1].X_WO.translation().y() = 0.5;  // it passes by
  const RolloutAnswer found = answer(1'000'000);
  EXPECT_EQ(found.manoeuvre.kind, ManoeuvreKind::kContinue);
  EXPECT_LE(search_.ticks(), 121U);  // 1.5 s of 25 ms
}

}  // namespace
}  // namespace hecaton::planner
