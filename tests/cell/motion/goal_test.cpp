// Goals of one arm, through real planner, driver and world processes.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/cell/motion/motion_cell.hpp"

namespace hecaton::test {
namespace {

double farthest_joint(const std::vector<double>& a, const std::vector<double>& b) {
  double farthest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) farthest = std::max(farthest, std::abs(a[i] - b[i]));
  return farthest;
}

using MotionGoal = MotionCell;

TEST_F(MotionGoal, IsReachedByTheMeasuredArm) {
  start_all();
  ASSERT_LT(farthest_joint(arm()->q(), kHome), 1e-3) << "an arm starts at its cell's start configuration";
  send(joint_goal("g1", kReady));
  ASSERT_TRUE(await([&] { return is("g1", msg::GoalState::GOAL_REACHED); }));
  EXPECT_TRUE(ever("g1", msg::GoalState::GOAL_ACTIVE));
  // The cell's goal tolerance. The drive approaches the goal while the status is on its way.
  EXPECT_LE(farthest_joint(arm()->q(), kReady), 2e-3);
  EXPECT_LE(status("g1")->distance_to_goal(), 2e-3 * std::sqrt(6.0));
  ASSERT_TRUE(await([&] {
    const auto& reports = reports_.latest();
    return !reports.empty() && reports.begin()->second.value.has_smallest();
  }));
  EXPECT_EQ(reports_.latest().begin()->second.value.contacts(), 0U);
}

TEST_F(MotionGoal, ReachesNamedAndToolPoseGoals) {
  start_all();
  msg::Goal named = joint_goal("named", {});
  named.kind(msg::GoalKind::GOAL_NAMED);
  named.named("ready");
  send(named);
  ASSERT_TRUE(await([&] { return is("named", msg::GoalState::GOAL_REACHED); })) << status("named")->cause().text();
  EXPECT_LT(farthest_joint(arm()->q(), kReady), 5e-3);

  // In front of the arm, tool pointing down: half a turn about x.
  msg::Goal pose = joint_goal("pose", {});
  pose.kind(msg::GoalKind::GOAL_POSE);
  pose.tool().X_WT().position().x(0.5);
  pose.tool().X_WT().position().y(0.15);
  pose.tool().X_WT().position().z(0.7);
  pose.tool().X_WT().qw(0.0);
  pose.tool().X_WT().qx(1.0);
  send(pose);
  ASSERT_TRUE(
      await([&] { return is("pose", msg::GoalState::GOAL_REACHED) || is("pose", msg::GoalState::GOAL_REJECTED); }));
  EXPECT_EQ(status("pose")->state(), msg::GoalState::GOAL_REACHED) << status("pose")->cause().text();
  EXPECT_GE(status("pose")->position_error(), 0.0);
  EXPECT_LE(status("pose")->position_error(), 1e-3);
  EXPECT_LE(status("pose")->orientation_error(), 0.00873);
}

TEST_F(MotionGoal, IsRejectedWithASentenceWhenBadWhileTheArmMovesOn) {
  start_all();
  send(joint_goal("good", {2.5, -1.9, 2.6, 0, 0.6, 0}));
  ASSERT_TRUE(await([&] { return is("good", msg::GoalState::GOAL_ACTIVE) && moves(); }));

  struct Bad {
    std::string goal;
    std::vector<double> q;
    std::string text;  ///< part of the sentence
  };
  const std::vector<Bad> bad{
      {"limits", {9.0, -1.9, 2.6, 0, 0.6, 0}, " = 9 must be within "},
      {"count", {0, 0, 0}, "goal has 3 joint values, arm arm1 has 6 joints"},
  };
  for (const Bad& goal : bad) send(joint_goal(goal.goal, goal.q));
  msg::Goal unknown = joint_goal("unknown", {});
  unknown.kind(msg::GoalKind::GOAL_NAMED);
  unknown.named("nowhere");
  send(unknown);
  msg::Goal far = joint_goal("far", {});
  far.kind(msg::GoalKind::GOAL_POSE);
  far.tool().X_WT().position().x(5.0);
  far.tool().X_WT().qw(1.0);
  send(far);
  for (const Bad& goal : bad) {
    ASSERT_TRUE(await([&] { return is(goal.goal, msg::GoalState::GOAL_REJECTED); })) << goal.goal;
    EXPECT_NE(status(goal.goal)->cause().text().find(goal.text), std::string::npos)
        << status(goal.goal)->cause().text();
  }
  ASSERT_TRUE(
      await([&] { return is("unknown", msg::GoalState::GOAL_REJECTED) && is("far", msg::GoalState::GOAL_REJECTED); }));
  EXPECT_NE(status("unknown")->cause().text().find("it has home, ready"), std::string::npos)
      << status("unknown")->cause().text();
  EXPECT_NE(status("far")->cause().text().find("cannot be at (5, 0, 0)"), std::string::npos)
      << status("far")->cause().text();

  ASSERT_TRUE(await([&] { return is("good", msg::GoalState::GOAL_REACHED); }));
  EXPECT_FALSE(ever("good", msg::GoalState::GOAL_REPLACED));
}

TEST_F(MotionGoal, IsRefusedOnTheWireWhenNotFinite) {
  start_all();
  send(joint_goal("nan", {0, std::numeric_limits<double>::quiet_NaN(), 2.6, 0, 0.6, 0}));
  EXPECT_TRUE(await([&] {
    const auto& refusals = alive_["planner/arm1"].refusals();
    return std::any_of(refusals.begin(), refusals.end(), [](const msg::Refusal& refusal) {
      return refusal.topic() == "Goal" && refusal.cause().text().find("q[1] = nan") != std::string::npos;
    });
  }));
  EXPECT_EQ(status("nan"), nullptr);
}

TEST_F(MotionGoal, IsRejectedInCollisionWithAnObstacle) {
  start_all();
  msg::WorldEditRequest add;
  add.kind(msg::EditKind::EDIT_ADD);
  // A first goal finds the tool's position in the "ready" pose.
  send(joint_goal("there", kReady));
  ASSERT_TRUE(await([&] { return is("there", msg::GoalState::GOAL_REACHED); }));
  send(joint_goal("back", kHome));
  ASSERT_TRUE(await([&] { return is("back", msg::GoalState::GOAL_REACHED); }));
  // A wall through the base's whole neighbourhood at x = 0.45 m: "ready" reaches beyond it, home does not touch it.
  msg::Obstacle wall = box("wall", 0.62, 0, 0.6);
  wall.shapes()[0].dimensions().x(0.1);
  wall.shapes()[0].dimensions().y(0.8);
  wall.shapes()[0].dimensions().z(0.3);
  add.obstacle(wall);
  const auto reply = edit(add);
  ASSERT_TRUE(reply.done()) << reply.cause().text();
  // Edits and goals use different topics, so the test repeats the goal until the planner knows the wall.
  int attempt = 0;
  ASSERT_TRUE(await([&] {
    const std::string goal = "into" + std::to_string(attempt);
    if (attempt > 0 && !is(goal, msg::GoalState::GOAL_REJECTED) && !is(goal, msg::GoalState::GOAL_ACTIVE)) return false;
    if (attempt > 0 && is(goal, msg::GoalState::GOAL_REJECTED)) return true;
    ++attempt;
    send(joint_goal("into" + std::to_string(attempt), kReady));
    return false;
  }));
  const std::string reason = status("into" + std::to_string(attempt))->cause().text();
  EXPECT_NE(reason.find("in collision: arm1/"), std::string::npos) << reason;
  EXPECT_NE(reason.find("wall"), std::string::npos) << reason;
}

TEST_F(MotionGoal, IsReplacedByALaterGoalAndStopsWhenCancelled) {
  start_all();
  send(joint_goal("first", {2.5, -1.9, 2.6, 0, 0.6, 0}));
  ASSERT_TRUE(await([&] { return is("first", msg::GoalState::GOAL_ACTIVE) && moves(); }));
  msg::Goal second = joint_goal("second", {-2.5, -1.9, 2.6, 0, 0.6, 0});
  send(second);
  ASSERT_TRUE(await([&] {
    return is("first", msg::GoalState::GOAL_REPLACED) && is("second", msg::GoalState::GOAL_ACTIVE) && moves();
  }));
  second.cancel(true);
  send(second);
  ASSERT_TRUE(await([&] { return is("second", msg::GoalState::GOAL_CANCELLED); }));
  ASSERT_TRUE(await([&] { return !moves(); }));
  EXPECT_FALSE(ever("second", msg::GoalState::GOAL_REACHED));
}

TEST_F(MotionGoal, EndsAtItsTimeLimit) {
  start_all();
  msg::Goal hasty = joint_goal("hasty", {2.5, -1.9, 2.6, 0, 0.6, 0});
  hasty.time_limit(0.3);  // 2.5 rad at 1.5 rad/s take more than 1.6 s
  send(hasty);
  ASSERT_TRUE(await([&] { return is("hasty", msg::GoalState::GOAL_TIMED_OUT); }));
  EXPECT_NE(status("hasty")->cause().text().find("not reached within 0.3 s"), std::string::npos);
}

// The arm is held, so that only the planner's checkpoint can bring it to the goal afterwards.
TEST_F(MotionGoal, IsResumedByARestartedPlanner) {
  const std::string checkpoint = path_ + ".goals";
  start_world();
  start_driver();
  const ChildProcess& first = start_planner("arm1", checkpoint);
  ASSERT_TRUE(await([&] { return arm() != nullptr && arm()->mode() == msg::ArmMode::ARM_RUNNING; }));
  set_mode(msg::Mode::MODE_HOLD, 1, "for the test");
  send(joint_goal("replaced", kHome));
  send(joint_goal("g", kReady));
  ASSERT_TRUE(await([&] { return status("g") != nullptr; }));
  first.signal(SIGKILL);
  ASSERT_TRUE(processes_.back().wait(10s).ended);
  goals_.clear_history();  // as if its client had left
  start_planner("arm1", checkpoint);
  set_mode(msg::Mode::MODE_RUN, 1);
  ASSERT_TRUE(await([&] { return is("g", msg::GoalState::GOAL_REACHED); }));
  EXPECT_LT(farthest_joint(arm()->q(), kReady), 5e-3);
  std::filesystem::remove(checkpoint);
}

}  // namespace
}  // namespace hecaton::test
