// A planner uses more memory than the cell file allows, while its arm and another one move.

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "services/runtime/join.hpp"
#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/grow_process.hpp"

namespace hecaton::services::testing {
namespace {

#ifdef __x86_64__
TEST(MemoryLimit, RestartsTheServiceThatExceedsItAlone) {
  HealthCell cell({}, "small_memory_cell.yaml");
  const msg::CellStatus before = cell.await_healthy();
  const int pid = pid_of_node(before, "planner/left");
  ASSERT_GT(pid, 0);
  const auto active = [](const msg::GoalStatus& goal) { return goal.state() == msg::GoalState::GOAL_ACTIVE; };
  const auto reached = [](const msg::CellStatus& status, const std::string& arm) {
    const msg::GoalStatus goal = arm_of(status, arm).goal();
    return goal.goal() == arm + " away" && goal.state() == msg::GoalState::GOAL_REACHED;
  };
  cell.send_goal("left", "left away", "away");
  cell.send_goal("right", "right away", "away");
  cell.await_goal("left away", active);
  ASSERT_TRUE(test::grow_process(pid, 400'000'000, kPatience));

  const msg::Fault fault = cell.await_fault("the planner's memory", [](const msg::Fault& reported) {
    return reported.cause().kind() == msg::CauseKind::CAUSE_PROCESS_DIED &&
           reported.cause().subject() == "planner/left" && !reported.cleared();
  });
  const std::string& text = fault.cause().text();
  EXPECT_EQ(text.find("planner/left: its agent ended process " + std::to_string(pid) + ": it used "), 0U) << text;
  EXPECT_NE(text.find(" MB of memory, more than supervision.memory_limit = 300 MB allows"), std::string::npos) << text;
  cell.await_mode("only left is held", [](const msg::CellMode& mode) {
    const auto held = arms_on(mode, msg::Mode::MODE_HOLD);
    return contains(held, "left") && !contains(held, "right") && mode.mode() == msg::Mode::MODE_RUN;
  });

  // The next planner continues the goal.
  cell.await("both goals are reached",
             [&](const msg::CellStatus& status) { return reached(status, "left") && reached(status, "right"); });
  const msg::CellStatus after = cell.await_healthy();
  for (const msg::HostStatus& host : before.hosts()) {
    for (const msg::ProcessEvent& process : host.processes()) {
      const auto now = process_of(after, process.name());
      ASSERT_TRUE(now) << process.name();
      EXPECT_EQ(now->pid() == process.pid(), process.node() != "planner/left") << process.name();
      EXPECT_EQ(now->restarts(), process.node() == "planner/left" ? 1U : 0U) << process.name();
    }
  }
}

TEST(MemoryLimit, ArmOfThePlannerStopsByItsOwnProfile) {
  HealthCell cell({"--no-restart"}, "small_memory_cell.yaml");
  const int pid = pid_of_node(cell.await_healthy(), "planner/left");
  ASSERT_GT(pid, 0);
  cell.send_goal("left", "left away", "away");
  cell.await_goal("left away", [](const msg::GoalStatus& goal) { return goal.state() == msg::GoalState::GOAL_ACTIVE; });
  ASSERT_TRUE(test::grow_process(pid, 400'000'000, kPatience));
  const msg::CellStatus stopped = cell.await("left stands", [](const msg::CellStatus& status) {
    const msg::ArmState state = arm_of(status, "left").state();
    return state.mode() == msg::ArmMode::ARM_STOPPED && open_faults(status, "process_died", "planner/left") == 1;
  });
  const msg::ArmState left = arm_of(stopped, "left").state();
  EXPECT_TRUE(std::all_of(left.qd().begin(), left.qd().end(), [](double speed) { return std::abs(speed) < 1e-3; }));
  EXPECT_LT(left.q().at(0), 2.49) << "it stopped on its way";
  EXPECT_EQ(arm_of(stopped, "right").state().mode(), msg::ArmMode::ARM_RUNNING);
}
#endif

}  // namespace
}  // namespace hecaton::services::testing
