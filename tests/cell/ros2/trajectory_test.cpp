/// Trajectories and action goals of ROS 2 without a running cell.

#include "services/ros2/trajectory.hpp"

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>
#include <idl/goal.h>

#include "services/bus/endpoint.hpp"
#include "services/ros2/action_checkpoint.hpp"
#include "services/ros2/trajectory_server.hpp"
#include "tests/cell/ros2/three_puma.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using namespace std::chrono_literals;

using planner::JointVector;
using ros2::TrajectoryCode;
using ros2::TrajectoryFollower;

ros2::TrajectoryGoal ramp(const JointVector& q, double step, double seconds) {
  ros2::TrajectoryGoal goal;
  goal.trajectory.joint_names = northern_arm().model->joint_names;
  for (int i = 0; i <= 4; ++i) {
    ros2::JointTrajectoryPoint point;
    point.positions.assign(q.begin(), q.end());
    point.positions[0] += step * i / 4.0;
    point.velocities.assign(point.positions.size(), 0.0);
    point.time_from_start = ros2::ros_duration(seconds * i / 4.0);
    goal.trajectory.points.push_back(point);
  }
  return goal;
}

TrajectoryCode code_of(const ros2::TrajectoryGoal& goal, double age = 0.0) {
  const auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), age);
  const auto* refusal = std::get_if<ros2::TrajectoryRefusal>(&checked);
  EXPECT_TRUE(refusal == nullptr || !refusal->text.empty());
  return refusal == nullptr ? TrajectoryCode::kSuccessful : refusal->code;
}

TEST(Ros2Trajectory, IsRefusedWithTheCodeOfItsError) {
  const JointVector& home = northern_arm().home();
  const ros2::TrajectoryGoal good = ramp(home, 0.4, 2.0);
  EXPECT_EQ(code_of(good), TrajectoryCode::kSuccessful);
  auto goal = good;
  for (std::string& name : goal.trajectory.joint_names) name = "north_" + name;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kSuccessful);
  goal.trajectory.joint_names[1] = goal.trajectory.joint_names[0];
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidJoints);
  goal = good;
  goal.trajectory.joint_names.pop_back();
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidJoints);
  goal = good;
  goal.trajectory.points[2].time_from_start = goal.trajectory.points[1].time_from_start;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  goal = good;
  goal.trajectory.points[0].positions[0] += 0.2;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal) << "it begins away from the arm";
  goal = good;
  goal.trajectory.points[3].positions[2] = 99.0;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  goal = good;
  goal.trajectory.points[3].positions[2] = std::nan("");
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  goal = good;
  goal.trajectory.points.back().velocities[0] = 0.5;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  EXPECT_EQ(code_of(ramp(home, 0.4, 0.2)), TrajectoryCode::kInvalidGoal) << "faster than the arm";
  goal = good;
  goal.trajectory.points.back().time_from_start.sec = 3601;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal) << "longer than an hour";
  goal.trajectory.points.back().time_from_start.sec = 3600;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kSuccessful);
  goal = good;
  goal.path_tolerance.push_back({"no_joint", 0.1, 0.0, 0.0});
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidJoints);
  EXPECT_EQ(code_of(good, 5.0), TrajectoryCode::kOldStamp);
  EXPECT_EQ(code_of(good, -0.05), TrajectoryCode::kSuccessful) << "the clocks of two hosts may differ";
  EXPECT_EQ(code_of(good, -0.5), TrajectoryCode::kInvalidGoal) << "it would begin before its time";
  goal = good;
  goal.multi_dof_trajectory.joint_names = {"base"};
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal) << "without points, too";
  EXPECT_EQ(code_of(ros2::TrajectoryGoal{}), TrajectoryCode::kInvalidJoints);
}

TEST(Ros2Trajectory, IsRefusedWhenAToleranceIsNotANumber) {
  const double nan = std::nan("");
  auto goal = ramp(northern_arm().home(), 0.4, 2.0);
  goal.path_tolerance.push_back({"joint2", nan, 0.0, 0.0});
  auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), 0.0);
  const auto* refusal = std::get_if<ros2::TrajectoryRefusal>(&checked);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->code, TrajectoryCode::kInvalidGoal);
  EXPECT_EQ(refusal->text, "path_tolerance of joint joint2 is not a number; 0 gives the joint no tolerance");
  goal.path_tolerance.clear();
  goal.goal_tolerance.push_back({"north_joint2", nan, 0.0, 0.0});
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  goal.goal_tolerance[0] = {"joint2", 0.1, nan, nan};
  EXPECT_EQ(code_of(goal), TrajectoryCode::kSuccessful) << "those of velocities and accelerations are ignored";
}

/// The arm `north` with a first joint that turns without end.
planner::Arm turning_arm() {
  planner::Arm arm = northern_arm();
  arm.limits.lower[0] = -std::numeric_limits<double>::infinity();
  arm.limits.upper[0] = std::numeric_limits<double>::infinity();
  return arm;
}

TEST(Ros2Trajectory, IsRefusedByTheNameOfTheFieldThatNoMessageToAPlannerMayHave) {
  const auto text_of = [](const ros2::TrajectoryGoal& goal) {
    const auto checked = ros2::check_trajectory(goal, turning_arm(), northern_arm().home(), 0.0);
    const auto* refusal = std::get_if<ros2::TrajectoryRefusal>(&checked);
    return refusal == nullptr ? "accepted" : refusal->text;
  };
  const auto good = ramp(northern_arm().home(), 0.4, 2.0);
  auto goal = good;
  for (auto& point : goal.trajectory.points) point.positions[0] = 1e7;
  EXPECT_EQ(text_of(goal), "trajectory.points[0].positions[0] = 1e+07 must be from -1e+06 to 1e+06");
  goal = good;
  goal.trajectory.points[1].velocities[2] = 2e4;
  EXPECT_EQ(text_of(goal), "trajectory.points[1].velocities[2] = 2e+04 must be from -1e+04 to 1e+04");
  goal = good;
  goal.trajectory.points[2].accelerations.assign(6, 0.0);
  goal.trajectory.points[2].accelerations[5] = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(text_of(goal), "trajectory.points[2].accelerations[5] = -inf must be from -1e+06 to 1e+06");
  goal = good;
  goal.path_tolerance.push_back({"joint2", 1e9, 0.0, 0.0});
  const auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), 0.0);
  ASSERT_TRUE(std::holds_alternative<ros2::TrajectoryOrder>(checked));
  EXPECT_FALSE(std::get<ros2::TrajectoryOrder>(checked).trajectory.has_path_tolerance()) << "it is none";

  // The limits are those of the message to the planner.
  msg::Goal message;
  const auto carried = [&](auto&& values, double largest) {
    values.assign(1, largest);
    const bool fits = !bus::Writer<msg::Goal>::refusal_of(message);
    values.assign(1, std::nextafter(largest, 2.0 * largest));
    const bool exceeds = bus::Writer<msg::Goal>::refusal_of(message).has_value();
    values.clear();
    return fits && exceeds;
  };
  EXPECT_TRUE(carried(message.q(), ros2::kLargestPosition));
  EXPECT_TRUE(carried(message.trajectory().q(), ros2::kLargestPosition));
  EXPECT_TRUE(carried(message.trajectory().qd(), ros2::kLargestVelocity));
  EXPECT_TRUE(carried(message.trajectory().qdd(), ros2::kLargestAcceleration));
  EXPECT_TRUE(carried(message.trajectory().path_tolerance(), ros2::kLargestPosition));
}

TEST(Ros2Trajectory, BeginsAtAnArmWhoseJointHasTurnedRound) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const planner::Arm arm = turning_arm();
  const JointVector& home = arm.home();
  JointVector turned = home;
  turned[0] += kTurn;
  const auto goal = ramp(home, 0.4, 2.0);
  EXPECT_TRUE(std::holds_alternative<ros2::TrajectoryOrder>(ros2::check_trajectory(goal, arm, turned, 0.0)));
  EXPECT_TRUE(
      std::holds_alternative<ros2::TrajectoryRefusal>(ros2::check_trajectory(goal, northern_arm(), turned, 0.0)))
      << "this joint does not turn without end";
  turned[0] += 0.06;
  EXPECT_TRUE(std::holds_alternative<ros2::TrajectoryRefusal>(ros2::check_trajectory(goal, arm, turned, 0.0)));

  auto later = goal;  // the arm comes to its first point within 0.5 s
  later.trajectory.points.erase(later.trajectory.points.begin());
  turned[0] = home[0] - 3.0 * kTurn;
  const auto checked = ros2::check_trajectory(later, arm, turned, 0.0);
  const auto* order = std::get_if<ros2::TrajectoryOrder>(&checked);
  ASSERT_TRUE(order) << std::get<ros2::TrajectoryRefusal>(checked).text;
  EXPECT_NEAR(order->at(0.0).q[0], home[0], 1e-9) << "it goes the short way";
  EXPECT_NEAR(order->at(0.25).q[0], home[0] + 0.05, 1e-9);
}

TEST(Ros2Trajectory, IsRefusedWhenAJointWouldTurnRoundTooFastBetweenItsPoints) {
  auto goal = ramp(northern_arm().home(), 0.4, 2.0);
  goal.trajectory.points[2].positions[0] += 2.0 * std::numbers::pi;
  const planner::Arm arm = turning_arm();
  const auto checked = ros2::check_trajectory(goal, arm, arm.home(), 0.0);
  ASSERT_TRUE(std::holds_alternative<ros2::TrajectoryRefusal>(checked)) << "the planner interpolates the turn";
}

TEST(Ros2Trajectory, MeasuresTheErrorOfATurningJointTheShortWay) {
  const planner::Arm arm = turning_arm();
  auto goal = ramp(arm.home(), 0.4, 2.0);
  goal.goal_tolerance.push_back({"joint1", 0.01, 0.0, 0.0});
  auto checked = ros2::check_trajectory(goal, arm, arm.home(), 0.0);
  TrajectoryFollower follower(std::get<ros2::TrajectoryOrder>(std::move(checked)));
  JointVector q = follower.order().trajectory.end();
  q[0] += 0.002 - 2.0 * std::numbers::pi;
  EXPECT_NEAR(follower.order().error(q, 2.0)[0], -0.002, 1e-9);
  const auto end = follower.update({q, 0.01, TrajectoryFollower::GoalReport::kReached, 2.0, 1.0});
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful) << end->text;
}

TrajectoryFollower follower_of(const ros2::TrajectoryGoal& goal) {
  auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), 0.0);
  return TrajectoryFollower(std::get<ros2::TrajectoryOrder>(std::move(checked)));
}

/// One that has come to `time` of the trajectory.
TrajectoryFollower::Input under_way(double time, double rate, std::string reason = {}) {
  return {northern_arm().home(), 0.01, TrajectoryFollower::GoalReport::kUnderWay, time, rate, std::move(reason)};
}

TEST(Ros2Trajectory, KeepsVelocitiesAndTolerancesOfItsPoints) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.path_tolerance.push_back({"joint2", 0.05, 0.0, 0.0});
  goal.path_tolerance.push_back({"joint3", -1.0, 0.0, 0.0});
  const auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), 0.0);
  const planner::TimedTrajectory& trajectory = std::get<ros2::TrajectoryOrder>(checked).trajectory;
  ASSERT_EQ(trajectory.points.size(), goal.trajectory.points.size());
  EXPECT_EQ(trajectory.duration(), 4.0);
  EXPECT_EQ(trajectory.points[2].qd.size(), northern_arm().home().size());
  EXPECT_EQ(trajectory.path_tolerance[1], 0.05);
  EXPECT_TRUE(std::isinf(trajectory.path_tolerance[2])) << "-1 erases a tolerance";
  EXPECT_TRUE(trajectory.has_path_tolerance());
}

TEST(Ros2Trajectory, HasTheTimeThatThePlannerReports) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 4.0));
  EXPECT_FALSE(follower.update(under_way(1.0, 1.0)));
  EXPECT_NEAR(follower.time(), 1.0, 1e-9);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(follower.update(under_way(1.0, 1.0)));
  EXPECT_NEAR(follower.time(), 1.1, 1e-9) << "between two reports it is estimated";
  EXPECT_FALSE(follower.update(under_way(1.05, 0.0)));
  EXPECT_NEAR(follower.time(), 1.1, 1e-9) << "it never falls";
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(follower.update(under_way(1.2, 0.5)));
  EXPECT_LT(follower.time(), 1.5) << "without a report the estimate ends";
}

TEST(Ros2Trajectory, SucceedsWhenThePlannerHasReachedItsEnd) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 4.0));
  TrajectoryFollower::Input input = under_way(4.0, 1.0);
  input.q = follower.order().trajectory.end();
  EXPECT_FALSE(follower.update(input));
  input.report = TrajectoryFollower::GoalReport::kReached;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful);
}

TEST(Ros2Trajectory, EndsWhenNoPlannerAnswersIt) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 60.0));
  TrajectoryFollower::Input input = under_way(0.0, 0.0);
  input.dt = 0.5;
  input.report = TrajectoryFollower::GoalReport::kUnanswered;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(follower.update(input)) << i;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kInvalidGoal);
  EXPECT_NE(end->text.find("no planner of the arm has answered the trajectory for 10 s"), std::string::npos)
      << end->text;

  TrajectoryFollower answered = follower_of(ramp(northern_arm().home(), 0.8, 60.0));
  EXPECT_FALSE(answered.update(input));
  input.report = TrajectoryFollower::GoalReport::kUnderWay;
  for (int i = 0; i < 40; ++i) EXPECT_FALSE(answered.update(input)) << i;
}

TEST(Ros2Trajectory, EndsWhenItsPlannerFallsSilent) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 60.0));
  TrajectoryFollower::Input input = under_way(0.0, 0.0);
  input.dt = 0.5;
  for (int i = 0; i < 100; ++i) {  // a held arm goes on reporting
    input.reported = 0.1 * i;
    EXPECT_FALSE(follower.update(input)) << i;
  }
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(follower.update(input)) << i;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kInvalidGoal);
  EXPECT_NE(end->text.find("no planner of the arm has answered the trajectory for 10 s"), std::string::npos);
}

TEST(Ros2Trajectory, WaitsLongerForAPlannerThatIsNotHeard) {
  using Report = TrajectoryFollower::GoalReport;
  for (const Report report : {Report::kUnanswered, Report::kUnreported, Report::kUnderWay}) {
    TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 60.0));
    TrajectoryFollower::Input input = under_way(0.0, 0.0);
    input.dt = 0.5;
    input.report = report;
    input.heard = false;
    for (int i = 0; i < 60; ++i) EXPECT_FALSE(follower.update(input)) << i;
    TrajectoryFollower started = follower;
    const auto end = follower.update(input);
    ASSERT_TRUE(end);
    EXPECT_EQ(end->code, TrajectoryCode::kInvalidGoal);
    EXPECT_TRUE(end->text.starts_with("no planner of the arm was heard for 30 s")) << end->text;

    input.heard = true;  // the agent has started a planner, which answers 4 s later
    for (int i = 0; i < 8; ++i) EXPECT_FALSE(started.update(input)) << i;
    input.report = Report::kUnderWay;
    input.reported = 40.0;
    EXPECT_FALSE(started.update(input));
    input.heard = false;
    for (int i = 0; i < 60; ++i) EXPECT_FALSE(started.update(input)) << "after an answer the time begins again " << i;
    EXPECT_TRUE(started.update(input));
  }
}

TEST(Ros2Trajectory, IsLostWhenAPlannerDoesNotReportItAfterARestart) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 60.0));
  TrajectoryFollower::Input input = under_way(0.0, 0.0);
  input.dt = 0.5;
  input.report = TrajectoryFollower::GoalReport::kUnreported;
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(follower.update(input)) << i;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kInvalidGoal);
  EXPECT_EQ(end->text, "the goal was lost: hecaton-ros2 was restarted, and no planner knows the goal");
}

TEST(Ros2Trajectory, CountsTheTimeBeforeARestart) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.goal_time_tolerance = {1, 0};
  auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), 0.0);
  TrajectoryFollower follower(std::get<ros2::TrajectoryOrder>(std::move(checked)), 4.5);
  TrajectoryFollower::Input input = under_way(2.0, 0.0);
  input.dt = 0.4;
  EXPECT_FALSE(follower.update(input));
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalTolerance);
}

TEST(Ros2CancellationWait, WaitsLongerForAPlannerThatIsNotHeard) {
  ros2::CancellationWait unheard;
  for (int i = 0; i < 60; ++i) EXPECT_FALSE(unheard.update({.dt = 0.5, .reported = 9.9, .heard = false})) << i;
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(unheard.update({.dt = 0.5, .reported = 9.9, .heard = true})) << i;
  for (int i = 0; i < 60; ++i) EXPECT_FALSE(unheard.update({.dt = 0.5, .reported = 9.9, .heard = false})) << i;
  const auto end = unheard.update({.dt = 0.5, .reported = 9.9, .heard = false});
  ASSERT_TRUE(end);
  EXPECT_TRUE(end->starts_with("canceled by its client; no planner of the arm was heard for 30 s")) << *end;

  ros2::CancellationWait restored;
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(restored.update({.dt = 0.5, .restored = true})) << i;
  EXPECT_EQ(restored.update({.dt = 0.5, .restored = true}), "canceled by its client");
}

TEST(Ros2CancellationWait, EndsWithItsGoalOrAfterASilenceOfThePlanner) {
  ros2::CancellationWait over;
  EXPECT_FALSE(over.update({.dt = 0.5, .reported = 1.0}));
  EXPECT_EQ(over.update({.dt = 0.5, .over = true, .reported = 1.5}), "canceled by its client");

  ros2::CancellationWait silent;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(silent.update({.dt = 0.5, .reported = 0.1 * i})) << i;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(silent.update({.dt = 0.5, .reported = 9.9})) << i;
  const auto end = silent.update({.dt = 0.5, .reported = 9.9});
  ASSERT_TRUE(end);
  EXPECT_NE(end->find("no planner of the arm has confirmed it for 10 s"), std::string::npos) << *end;
}

TEST(Ros2Trajectory, EndsOutsideItsGoalTolerance) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.goal_tolerance.push_back({"joint1", 0.001, 0.0, 0.0});
  TrajectoryFollower follower = follower_of(goal);
  TrajectoryFollower::Input input = under_way(4.0, 1.0);
  input.q = follower.order().trajectory.end();
  (*input.q)[0] += 0.002;
  input.report = TrajectoryFollower::GoalReport::kReached;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalTolerance);
  EXPECT_EQ(end->text, "joint joint1 ends 0.002 from the goal (tolerance 0.001)");
}

TEST(Ros2Trajectory, WaitsForItsGoalToleranceUntilTheTimeTolerance) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.goal_tolerance.push_back({"joint1", 0.001, 0.0, 0.0});
  goal.goal_time_tolerance = {1, 0};
  TrajectoryFollower settles = follower_of(goal);
  TrajectoryFollower::Input input = under_way(4.0, 1.0);
  input.q = settles.order().trajectory.end();
  (*input.q)[0] += 0.002;
  input.report = TrajectoryFollower::GoalReport::kReached;
  input.dt = 4.5;
  EXPECT_FALSE(settles.update(input)) << "0.5 s are left";
  TrajectoryFollower late = settles;
  input.dt = 0.01;
  (*input.q)[0] -= 0.0015;
  auto end = settles.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful) << end->text;
  (*input.q)[0] += 0.0015;
  input.dt = 0.6;
  end = late.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalTolerance);
  EXPECT_EQ(end->text, "joint joint1 ends 0.002 from the goal (tolerance 0.001)");
}

/// A trajectory of 4 s with a tolerance of joint 1, whose planner goes on reporting that its time has come to `time`.
class LooseEnd {
 public:
  explicit LooseEnd(double tolerance, double time = 4.0, bool returns = false) {
    auto goal = ramp(northern_arm().home(), 0.8, 4.0);
    if (returns) goal.trajectory.points.back().positions = goal.trajectory.points.front().positions;
    if (tolerance > 0.0) goal.goal_tolerance.push_back({"joint1", tolerance, 0.0, 0.0});
    follower_.emplace(follower_of(goal));
    input_ = under_way(time, 0.0);
    input_.q = follower_->order().trajectory.end();
  }
  TrajectoryFollower::Input& input() { return input_; }
  JointVector& q() { return *input_.q; }
  /// The end within `seconds` more.
  std::optional<ros2::TrajectoryRefusal> end_within(double seconds) {
    std::optional<ros2::TrajectoryRefusal> end;
    for (double time = 0.0; !end && time < seconds; time += input_.dt) {
      reported_ += input_.dt;
      input_.reported = reported_;
      end = follower_->update(input_);
    }
    return end;
  }

 private:
  std::optional<TrajectoryFollower> follower_;
  TrajectoryFollower::Input input_ = under_way(0.0, 0.0);
  double reported_ = 0.0;
};

TEST(Ros2Trajectory, SucceedsAtRestWithinALooseGoalTolerance) {
  LooseEnd rests(0.1);
  rests.q()[0] -= 0.05;
  EXPECT_FALSE(rests.end_within(3.9)) << "its time is not over";
  const auto end = rests.end_within(1.0);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful) << end->text;

  LooseEnd without(0.0);
  without.q()[0] -= 0.001;
  EXPECT_FALSE(without.end_within(20.0)) << "the planner's tolerance counts alone";
  LooseEnd outside(0.04);
  outside.q()[0] -= 0.05;
  EXPECT_FALSE(outside.end_within(20.0));
  LooseEnd other_joint(0.1);
  other_joint.q()[1] += 0.05;
  EXPECT_FALSE(other_joint.end_within(20.0)) << "joint 2 has no tolerance of its own";
  LooseEnd old(0.1);
  old.input().q_age = 1.0;
  EXPECT_FALSE(old.end_within(20.0)) << "the driver is silent: the arm may move";
  LooseEnd moves(0.1);
  for (int i = 0; i < 200; ++i) {
    moves.q()[0] += i % 2 == 0 ? 0.005 : -0.005;
    EXPECT_FALSE(moves.end_within(0.1)) << i;
  }
}

TEST(Ros2Trajectory, IsNotOverWhereItPassesItsEndBefore) {
  LooseEnd stopped_at_start(0.1, 0.5, true);
  EXPECT_FALSE(stopped_at_start.end_within(20.0)) << "something stops the arm near its first point, which is the last";
  LooseEnd stopped_near_end(0.1, 3.9, true);
  EXPECT_TRUE(stopped_near_end.end_within(20.0));
}

TEST(Ros2Trajectory, EndsWithoutAStateOfItsArm) {
  TrajectoryFollower silent = follower_of(ramp(northern_arm().home(), 0.8, 4.0));
  TrajectoryFollower::Input input = under_way(0.0, 0.0);
  input.q.reset();
  input.dt = 11.0;
  input.report = TrajectoryFollower::GoalReport::kUnanswered;
  auto end = silent.update(input);
  ASSERT_TRUE(end);
  EXPECT_NE(end->text.find("no planner of the arm has answered"), std::string::npos) << end->text;

  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  input.report = TrajectoryFollower::GoalReport::kReached;
  TrajectoryFollower arrived = follower_of(goal);
  end = arrived.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful) << "it has no tolerance to check";
  goal.goal_tolerance.push_back({"joint1", 0.1, 0.0, 0.0});
  TrajectoryFollower unchecked = follower_of(goal);
  input.dt = 6.0;
  EXPECT_FALSE(unchecked.update(input));
  end = unchecked.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalTolerance);
  EXPECT_NE(end->text.find("has sent no state for 10 s"), std::string::npos) << end->text;
}

TEST(Ros2Trajectory, EndsWhenItsTimeToleranceIsOver) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.goal_time_tolerance = {1, 0};
  TrajectoryFollower follower = follower_of(goal);
  double elapsed = 0.0;
  std::optional<ros2::TrajectoryRefusal> end;
  while (!end && elapsed < 60.0) {
    elapsed += 0.01;
    end = follower.update(under_way(2.0, 0.0, "ball is 0.03 m away"));
  }
  EXPECT_NEAR(elapsed, 5.0, 0.1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalTolerance);
  EXPECT_NE(end->text.find("ball is 0.03 m away"), std::string::npos);
}

TEST(Ros2Trajectory, SaysWhyItWasLateWhenNothingBindsItAnyMore) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.goal_time_tolerance = {1, 0};
  TrajectoryFollower follower = follower_of(goal);
  TrajectoryFollower::Input input = under_way(1.0, 0.0, "ball is 0.03 m away");
  input.dt = 3.0;
  EXPECT_FALSE(follower.update(input));
  input.reason.clear();
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalTolerance);
  EXPECT_NE(end->text.find("it was late before: ball is 0.03 m away"), std::string::npos) << end->text;
}

TEST(Ros2Trajectory, EndsAsItsPlannerSays) {
  using Report = TrajectoryFollower::GoalReport;
  const std::vector<std::tuple<Report, TrajectoryCode, std::string>> ends{
      {Report::kRejected, TrajectoryCode::kInvalidGoal, "the planner rejects the trajectory: ball is 0.03 m away"},
      {Report::kReplaced, TrajectoryCode::kInvalidGoal,
       "a later goal has replaced this trajectory: ball is 0.03 m away"},
      {Report::kLost, TrajectoryCode::kInvalidGoal, "the goal was lost: ball is 0.03 m away"},
      {Report::kLeftPath, TrajectoryCode::kPathTolerance, "ball is 0.03 m away"}};
  for (const auto& [report, code, text] : ends) {
    TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 4.0));
    TrajectoryFollower::Input input = under_way(1.0, 0.0, "ball is 0.03 m away");
    input.report = report;
    const auto end = follower.update(input);
    ASSERT_TRUE(end);
    EXPECT_EQ(end->code, code);
    EXPECT_EQ(end->text, text);
  }
}

TEST(Ros2ActionGoals, KeepResultsForLateClients) {
  ros2::ActionGoals goals;
  const ros2::ActionGoals::Id id{1, 2, 3};
  const auto now = bus::Clock::now();
  ASSERT_TRUE(goals.add(id, {5, 0}));
  EXPECT_FALSE(goals.add(id, {6, 0}));
  EXPECT_FALSE(goals.result(id)) << "the goal has not ended";
  goals.end(id, ros2::ActionGoals::kSucceeded, {0, "done"}, now);
  goals.forget_old(now + 14min);
  ASSERT_TRUE(goals.result(id));
  EXPECT_EQ(goals.result(id)->result.error_string, "done");
  goals.forget_old(now + 16min);
  EXPECT_EQ(goals.result(id)->status, ros2::ActionGoals::kUnknown);
}

// As rcl_action_process_cancel_request() answers.
TEST(Ros2ActionGoals, NameThoseThatACancellationMeans) {
  ros2::ActionGoals goals;
  const ros2::ActionGoals::Id none{};
  const ros2::ActionGoals::Id ended{1};
  const ros2::ActionGoals::Id running{2};
  const ros2::ActionGoals::Id later{3};
  const auto answer = [&](const ros2::ActionGoals::Id& id, const ros2::Time& stamp) {
    const auto response = goals.cancellable({{id}, stamp});
    std::vector<int> numbers;
    for (const auto& goal : response.goals_canceling) numbers.push_back(goal.goal_id.uuid[0]);
    return std::pair(int{response.return_code}, numbers);
  };
  using Answer = std::pair<int, std::vector<int>>;
  EXPECT_EQ(answer(none, {0, 0}), (Answer{0, {}}));
  EXPECT_EQ(answer(none, {9, 0}), (Answer{0, {}}));
  EXPECT_EQ(answer(running, {9, 0}), (Answer{0, {}}));
  EXPECT_EQ(answer(running, {0, 0}), (Answer{2, {}}));
  constexpr std::int32_t kSeconds = 1'800'000'000;
  ASSERT_TRUE(goals.add(ended, {5, 0}) && goals.add(running, {kSeconds, 7}) && goals.add(later, {kSeconds, 8}));
  goals.end(ended, ros2::ActionGoals::kSucceeded, {}, bus::Clock::now());
  EXPECT_EQ(answer(ended, {0, 0}), (Answer{3, {}}));
  EXPECT_EQ(answer(running, {0, 0}), (Answer{0, {2}}));
  EXPECT_EQ(answer(none, {0, 0}), (Answer{0, {2, 3}}));
  EXPECT_EQ(answer(none, {kSeconds, 6}), (Answer{0, {}}));
  EXPECT_EQ(answer(none, {kSeconds, 7}), (Answer{0, {2}})) << "to the nanosecond";
  EXPECT_EQ(answer(later, {kSeconds, 7}), (Answer{0, {2, 3}})) << "the goal, and all until then";
}

TEST(Ros2ActionGoals, AreTheSameAfterARestart) {
  const auto now = bus::Clock::now();
  ros2::ActionGoals before;
  const ros2::ActionGoals::Id done{1};
  const ros2::ActionGoals::Id under_way{2};
  ASSERT_TRUE(before.add(done, {5, 0}) && before.add(under_way, {6, 0}));
  before.end(done, ros2::ActionGoals::kAborted, {-4, "pushed"}, now - 10min);
  before.set_status(under_way, ros2::ActionGoals::kCanceling);
  ros2::ActionGoals after;
  after.restore(before.saved());
  EXPECT_EQ(after.info(under_way).stamp.sec, 6);
  EXPECT_EQ(after.status(under_way), ros2::ActionGoals::kCanceling);
  EXPECT_FALSE(after.result(under_way));
  ASSERT_TRUE(after.result(done));
  EXPECT_EQ(after.result(done)->result.error_string, "pushed");
  EXPECT_EQ(after.statuses().status_list.front().goal_info.goal_id.uuid, done);
  after.forget_old(now + 6min);
  EXPECT_FALSE(after.knows(done)) << "its age counts from its end";
}

TEST(Ros2ResultRequests, DropRepetitionsOfAClientFirst) {
  const ros2::ActionGoals::Id goal{1};
  const ros2::ActionGoals::Id other_goal{2};
  const bus::EndpointId patient{{1}};
  const bus::EndpointId polling{{2}};
  ros2::ResultRequests requests;
  requests.add(goal, {patient, 1});
  requests.add(other_goal, {polling, 1});
  for (int i = 0; i < 1000; ++i) requests.add(goal, {polling, 2 + i});
  const auto& all = requests.all();
  ASSERT_EQ(all.size(), ros2::ResultRequests::kMost);
  EXPECT_EQ(all[0].request, (bus::ros2::RequestId{patient, 1}));
  EXPECT_EQ(all[1].goal, other_goal) << "it is for another goal";
  EXPECT_EQ(all.back().request.number, 1001) << "the newest one stays";
  const std::size_t answered = requests.answer([&](const auto& entry) { return entry.request.client == polling; });
  EXPECT_EQ(answered, ros2::ResultRequests::kMost - 1);
  EXPECT_EQ(requests.all().size(), 1U);
  for (std::uint8_t i = 0; i < 64; ++i) requests.add(goal, {bus::EndpointId{{3, i}}, 1});
  EXPECT_EQ(requests.all().size(), ros2::ResultRequests::kMost);
  EXPECT_EQ(requests.all()[0].request.client, (bus::EndpointId{{3, 0}})) << "without repetitions the oldest goes";
}

TEST(Ros2Cancellations, AreRepeatedEachSecondUntilTheyAreSent) {
  ros2::Cancellations cancellations("north");
  const auto now = bus::Clock::now();
  int first = 0;
  int second = 0;
  bool works = false;
  cancellations.add(
      "sent", [&] { ++first; }, now);
  const auto fails = [&] {
    ++second;
    if (!works) throw Unreachable({"the cancellation could not be sent", {}, "the planner"});
  };
  cancellations.add("unsent", fails, now);
  EXPECT_EQ(cancellations.unsent(), std::vector<std::string>{"unsent"});
  cancellations.retry(now + 900ms);
  EXPECT_EQ(second, 1);
  cancellations.retry(now + 1s);
  EXPECT_EQ(second, 2);
  cancellations.retry(now + 1900ms);
  EXPECT_EQ(second, 2);
  cancellations.add("unsent", fails, now + 1900ms);
  EXPECT_EQ(cancellations.unsent().size(), 1U) << "it is one goal";
  works = true;
  cancellations.retry(now + 3s);
  EXPECT_EQ(second, 4);
  EXPECT_TRUE(cancellations.unsent().empty());
  cancellations.retry(now + 10s);
  EXPECT_EQ(second, 4);
  EXPECT_EQ(first, 1);
}

TEST(Ros2ActionCheckpoint, KeepsWhatWasSavedLast) {
  const TemporaryFolder folder;
  const std::string path = folder.path("ros2-north");
  EXPECT_FALSE(ros2::ActionCheckpoint(path).load("north")) << "nothing is saved";
  ros2::SavedAction action{"north", {}, {{{{7}}, {8}, 9}}, {}, {"client/host-1/0"}};
  ros2::SavedTrajectory& active = action.active.emplace_back();
  active.goal = "client/host-1/2";
  active.order.trajectory.joint_names = {"joint1"};
  active.start = {0.5};
  active.begun_ns = 123;
  active.replaced = {"client/host-1/1"};
  ros2::ActionCheckpoint checkpoint(path);
  checkpoint.save({"north", {}, {}, {}, {}});
  checkpoint.save(action);
  const auto loaded = ros2::ActionCheckpoint(path).load("north");
  ASSERT_TRUE(loaded);
  EXPECT_EQ(encoded(*loaded), encoded(action));
  EXPECT_FALSE(ros2::ActionCheckpoint(path).load("west")) << "of another arm";
  std::filesystem::resize_file(path, 40);
  EXPECT_FALSE(ros2::ActionCheckpoint(path).load("north")) << "damaged";
  folder.write("ros2-north", "abc");
  EXPECT_FALSE(ros2::ActionCheckpoint(path).load("north")) << "damaged";
}

}  // namespace
}  // namespace hecaton::test
