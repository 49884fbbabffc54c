#include "services/planner/goal_resolver.hpp"

#include <cmath>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

#include "planner/model/kinematics.hpp"
#include "services/config/cell_file.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services {
namespace {

using planner::JointVector;

std::string text(const GoalAnswer& answer) {
  return answer.rejection ? answer.rejection->text() : "";
}

class Resolve : public testing::Test {
 protected:
  static planner::Cell cell(const std::string& urdf) {
    const std::string joints = urdf == "puma560" ? "[0, -1.9, 2.6, 0, 0.6, 0]" : "[0, -1.9, 2.6, 0, 0.6]";
    const std::string text = "name: c\narms: [{name: arm1, urdf: urdf/" + urdf + ".urdf, poses: {home: " + joints +
                             ", up: " + joints + "}}]\n";
    return config::parse_cell_file(text, std::string(HECATON_SOURCE_DIR) + "/deploy/cells/test.yaml").cell;
  }
  explicit Resolve(const std::string& urdf = "puma560")
      : cell_(cell(urdf)), geometry_({cell_.arms[0].arm}, 0), q_now_(cell_.arms[0].arm.home()) {}

  [[nodiscard]] GoalAnswer resolve(const msg::Goal& goal) const {
    return resolve_goal(geometry_, goal, q_now_, states_);
  }
  static msg::Goal joints(const std::vector<double>& q) {
    msg::Goal goal;
    goal.arm("arm1");
    goal.goal("g");
    goal.kind(msg::GoalKind::GOAL_JOINTS);
    goal.q(q);
    return goal;
  }
  static msg::Goal named(const std::string& name) {
    msg::Goal goal = joints({});
    goal.kind(msg::GoalKind::GOAL_NAMED);
    goal.named(name);
    return goal;
  }
  static msg::Goal pose(const world::Pose& X_WT) {
    msg::Goal goal = joints({});
    goal.kind(msg::GoalKind::GOAL_POSE);
    goal.tool().X_WT(messages::to_message(X_WT));
    return goal;
  }
  [[nodiscard]] world::Pose tool(const JointVector& q) const {
    planner::Kinematics kinematics;
    planner::forward_kinematics(*cell_.arms[0].arm.model, cell_.arms[0].arm.X_WB, q, kinematics);
    return kinematics.X_WT;
  }
  /// A ball at p_W.
  void put_ball(const Eigen::Vector3d& p_W, double radius) {
    world::Obstacle ball;
    ball.name = "ball";
    ball.shapes.emplace_back().shape = world::Sphere{radius};
    geometry_.set_obstacles(std::vector{ball});
    world::ObstacleState state;
    state.X_WO.translation() = p_W;
    states_ = {state};
  }

  planner::Cell cell_;
  planner::CellGeometry geometry_;
  JointVector q_now_;
  std::vector<world::ObstacleState> states_;
};

/// From home in two seconds, 0.1 rad farther.
msg::Goal trajectory(const JointVector& from) {
  msg::Goal goal;
  goal.arm("arm1");
  goal.goal("g");
  goal.kind(msg::GoalKind::GOAL_TRAJECTORY);
  const JointVector to = from + JointVector::Constant(from.size(), 0.1);
  goal.trajectory().time({0.0, 2.0});
  goal.trajectory().q().assign(from.begin(), from.end());
  goal.trajectory().q().insert(goal.trajectory().q().end(), to.begin(), to.end());
  return goal;
}

TEST_F(Resolve, AcceptsATrajectoryToItsEnd) {
  const GoalAnswer answer = resolve(trajectory(q_now_));
  ASSERT_FALSE(answer.rejection) << text(answer);
  ASSERT_TRUE(answer.trajectory);
  EXPECT_EQ(answer.trajectory->points.size(), 2U);
  EXPECT_EQ(answer.q_goal, answer.trajectory->end());
}

TEST_F(Resolve, NamesWhatIsWrongWithATrajectory) {
  msg::Goal goal = trajectory(q_now_);
  goal.trajectory().q().pop_back();
  EXPECT_NE(text(resolve(goal)).find("trajectory.q has 11 values, but must have 12"), std::string::npos);
  goal = trajectory(q_now_);
  goal.trajectory().qd({1.0});
  EXPECT_NE(text(resolve(goal)).find("0 or 12"), std::string::npos);
  goal = trajectory(q_now_);
  goal.trajectory().time({1.0, 1.0});
  EXPECT_NE(text(resolve(goal)).find("the time of point 1"), std::string::npos);
  goal = trajectory(q_now_);
  goal.trajectory().q()[7] = 99.0;
  EXPECT_NE(text(resolve(goal)).find("= 99 of point 1"), std::string::npos);
  goal = trajectory(q_now_ + JointVector::Constant(q_now_.size(), 0.2));
  EXPECT_NE(text(resolve(goal)).find("begins 0.2"), std::string::npos);
  EXPECT_FALSE(resolve_goal(geometry_, goal, q_now_, states_, false).rejection) << "another planner has begun it";
}

TEST_F(Resolve, AcceptsJointsAndNamedPoses) {
  const GoalAnswer answer = resolve(joints({0.1, -1.8, 2.5, 0.2, 0.5, -0.3}));
  ASSERT_FALSE(answer.rejection) << text(answer);
  EXPECT_EQ(answer.q_goal[3], 0.2);
  EXPECT_EQ(answer.goal.goal(), "g");
  const GoalAnswer up = resolve(named("up"));
  ASSERT_FALSE(up.rejection) << text(up);
  EXPECT_EQ(up.q_goal[1], -1.9);
  EXPECT_EQ(resolve(named("down")).rejection.value().kind(), msg::CauseKind::CAUSE_UNKNOWN_NAME);
  EXPECT_EQ(text(resolve(named("down"))), "arm arm1 has no pose named \"down\"; it has home, up");
}

TEST_F(Resolve, MovesAJointOntoItsLimitWhenItIsOutsideByRounding) {
  const double limit = cell_.arms[0].arm.limits.upper[5];
  const GoalAnswer rounded = resolve(joints({0.1, -1.8, 2.5, 0.2, 0.5, limit + 1e-10}));
  ASSERT_FALSE(rounded.rejection) << text(rounded);
  EXPECT_EQ(rounded.q_goal[5], limit);
  EXPECT_NE(rounded.note.find("is outside its limit by rounding"), std::string::npos) << rounded.note;
  const GoalAnswer outside = resolve(joints({0.1, -1.8, 2.5, 0.2, 0.5, limit + 5e-4}));
  ASSERT_TRUE(outside.rejection);
  EXPECT_EQ(outside.rejection->kind(), msg::CauseKind::CAUSE_GOAL_OUTSIDE_LIMITS);
}

TEST_F(Resolve, RejectsMalformedGoals) {
  EXPECT_EQ(text(resolve(joints(std::vector<double>(40, 0.0)))), "goal has 40 joint values, arm arm1 has 6 joints");
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_NE(text(resolve(joints({inf, 0, 0, 0, 0, 0}))).find("= inf must be a finite number"), std::string::npos);
  msg::Goal goal = joints({0, -1.9, 2.6, 0, 0.6, 0});
  for (const double limit : {-1.0, std::nan(""), inf}) {
    goal.time_limit(limit);
    EXPECT_NE(text(resolve(goal)).find("time_limit"), std::string::npos) << limit;
  }
  msg::Goal skewed = pose(tool(q_now_));
  skewed.tool().X_WT().qw(3.0);
  EXPECT_NE(text(resolve(skewed)).find("quaternion"), std::string::npos);
  msg::Goal loose = pose(tool(q_now_));
  loose.tool().position_tolerance(-0.1);
  EXPECT_NE(text(resolve(loose)).find("position_tolerance"), std::string::npos);
}

TEST_F(Resolve, SolvesReachablePoses) {
  JointVector q(6);
  q << 0.7, -1.4, 3.0, 0.4, 0.8, -0.5;
  const world::Pose wanted = tool(q);
  const GoalAnswer answer = resolve(pose(wanted));
  ASSERT_FALSE(answer.rejection) << text(answer);
  const world::Pose reached = tool(answer.q_goal);
  EXPECT_LT((reached.translation() - wanted.translation()).norm(), 2e-4);
  EXPECT_LT(Eigen::AngleAxisd(reached.linear().transpose() * wanted.linear()).angle(), 2e-3);
}

TEST_F(Resolve, RejectsUnreachablePoses) {
  world::Pose far = world::Pose::Identity();
  far.translation().x() = 3.0;
  const GoalAnswer answer = resolve(pose(far));
  EXPECT_TRUE(answer.rejection);
  EXPECT_NE(text(answer).find("the tool of arm arm1 cannot be at (3, 0, 0): that is "), std::string::npos)
      << text(answer);
  EXPECT_EQ(answer.rejection->kind(), msg::CauseKind::CAUSE_GOAL_UNREACHABLE);
  EXPECT_NE(text(answer).find("it reaches no farther than "), std::string::npos) << text(answer);

  world::Pose inside_itself = world::Pose::Identity();
  inside_itself.translation().z() = 0.67;  // the first joint's origin
  const GoalAnswer near = resolve(pose(inside_itself));
  EXPECT_TRUE(near.rejection);
  EXPECT_NE(text(near).find("no joint positions within the limits were found"), std::string::npos) << text(near);
}

TEST_F(Resolve, NamesTheObstacleWhenEverySolutionCollides) {
  JointVector q(6);
  q << 0.7, -1.4, 3.0, 0.4, 0.8, -0.5;
  put_ball(tool(q).translation(), 0.05);
  const GoalAnswer answer = resolve(pose(tool(q)));
  EXPECT_TRUE(answer.rejection);
  EXPECT_NE(text(answer).find("ball"), std::string::npos) << text(answer);
  EXPECT_EQ(answer.rejection->kind(), msg::CauseKind::CAUSE_GOAL_IN_COLLISION);
  EXPECT_EQ(answer.rejection->subject(), "ball");
  EXPECT_NE(text(resolve(joints({q.data(), q.data() + 6}))).find("ball"), std::string::npos);
}

class ResolveFiveJoints : public Resolve {
 protected:
  ResolveFiveJoints() : Resolve("puma560_5dof") {}
};

// The arm has no joint that turns the tool about its own axis alone.
TEST_F(ResolveFiveJoints, RejectAnOrientationWithTheNearestOne) {
  JointVector q(5);
  q << 0.7, -1.4, 3.0, 0.4, 0.8;
  world::Pose wanted = tool(q);
  EXPECT_FALSE(resolve(pose(wanted)).rejection);
  wanted.linear() = wanted.linear() * Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ());
  const GoalAnswer answer = resolve(pose(wanted));
  ASSERT_TRUE(answer.rejection);
  EXPECT_EQ(answer.rejection->kind(), msg::CauseKind::CAUSE_GOAL_ORIENTATION);
  EXPECT_NE(text(answer).find("in that orientation: the nearest that it can take there is "), std::string::npos)
      << text(answer);
  ASSERT_TRUE(answer.nearest);
  EXPECT_GT(answer.nearest->angle, 0.1);
  EXPECT_LE(answer.nearest->angle, 1.0 + 1e-2);
  EXPECT_LT((answer.nearest->X_WT.translation() - wanted.translation()).norm(), 2e-4);
  EXPECT_FALSE(resolve(pose(answer.nearest->X_WT)).rejection) << "the nearest orientation is a goal";
}

TEST_F(ResolveFiveJoints, ReachAPositionInAnyOrientation) {
  JointVector q(5);
  q << 0.7, -1.4, 3.0, 0.4, 0.8;
  world::Pose wanted = tool(q);
  wanted.linear() = Eigen::Matrix3d::Identity();
  msg::Goal position = pose(wanted);
  position.tool().free_rotation(msg::FreeRotation::FREE_ALL);
  const GoalAnswer answer = resolve(position);
  ASSERT_FALSE(answer.rejection) << text(answer);
  EXPECT_LT((tool(answer.q_goal).translation() - wanted.translation()).norm(), 2e-4);
  EXPECT_EQ(answer.tool.value().free_rotation, planner::FreeRotation::kAll);
}

TEST_F(ResolveFiveJoints, MeetPositionAndToolAxisWithTheYawFree) {
  JointVector q(5);
  q << 0.7, -1.4, 3.0, 0.4, 0.8;
  world::Pose wanted = tool(q);
  wanted.linear() = wanted.linear() * Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ());
  msg::Goal free_yaw = pose(wanted);
  free_yaw.tool().free_rotation(msg::FreeRotation::FREE_YAW);
  const GoalAnswer answer = resolve(free_yaw);
  ASSERT_FALSE(answer.rejection) << text(answer);
  const world::Pose reached = tool(answer.q_goal);
  EXPECT_LT((reached.translation() - wanted.translation()).norm(), 2e-4);
  EXPECT_GT(reached.linear().col(2).dot(wanted.linear().col(2)), std::cos(2e-3));
}

TEST_F(Resolve, AnswersInTheOrderOfTheQuestions) {
  GoalResolver resolver(geometry_);
  const auto nothing = std::make_shared<const std::vector<world::Obstacle>>();
  resolver.ask({named("up"), q_now_, nothing, {}});
  resolver.ask({named("down"), q_now_, nothing, {}});
  std::vector<GoalAnswer> answers;
  while (answers.size() < 2) {
    for (GoalAnswer& answer : resolver.answers()) answers.push_back(std::move(answer));
    std::this_thread::yield();
  }
  EXPECT_FALSE(answers[0].rejection);
  EXPECT_TRUE(answers[1].rejection);
}

TEST_F(Resolve, RejectsATrajectoryForAMethodThatFollowsNone) {
  GoalResolver resolver(geometry_);
  GoalQuestion question{trajectory(q_now_), q_now_, std::make_shared<const std::vector<world::Obstacle>>(), {}};
  question.follows_trajectories = false;
  resolver.ask(question);
  std::vector<GoalAnswer> answers;
  while (answers.empty()) {
    answers = resolver.answers();
    std::this_thread::yield();
  }
  EXPECT_EQ(text(answers[0]), "the motion method of arm arm1 follows no trajectories; send its end");
}

TEST_F(Resolve, EndsWithOpenQuestions) {
  GoalResolver resolver(geometry_);
  const auto nothing = std::make_shared<const std::vector<world::Obstacle>>();
  for (int k = 0; k < 100; ++k) resolver.ask({named("up"), q_now_, nothing, {}});
}

}  // namespace
}  // namespace hecaton::services
