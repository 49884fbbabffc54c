// A planner dies while its arm moves to a goal that no client will send again.

#include <csignal>
#include <optional>

#include <gtest/gtest.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/join.hpp"
#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

/// Sends a goal from a client that leaves as soon as the arm moves.
void send_and_leave(HealthCell& cell, const std::string& goal, const std::string& named) {
  ServiceOptions options;
  options.domain = cell.domain();
  bus::Mailbox mailbox;
  bus::Participant participant = make_participant(cell.file(), options, Role::kOperator, "guest", &mailbox);
  bus::Writer<msg::Goal> goals(participant);
  msg::Goal message;
  message.arm("left");
  message.goal(goal);
  message.client("guest");
  message.sequence_number(1);
  message.kind(msg::GoalKind::GOAL_NAMED);
  message.named(named);
  ASSERT_TRUE(goals.write(message));
  cell.await_goal(goal,
                  [](const msg::GoalStatus& reported) { return reported.state() == msg::GoalState::GOAL_ACTIVE; });
}

TEST(HealthGoal, SurvivesThePlannerAfterItsClientHasLeft) {
  HealthCell cell;
  const int pid = pid_of_node(cell.await_healthy(), "planner/left");
  ASSERT_NO_FATAL_FAILURE(send_and_leave(cell, "left behind", "away"));
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  cell.await_goal("left behind",
                  [](const msg::GoalStatus& reported) { return reported.state() == msg::GoalState::GOAL_REACHED; });
  EXPECT_NEAR(cell.next_state("left").q().at(0), 2.5, 1e-2);
  cell.await("another planner", [&](const msg::CellStatus& seen) {
    const auto process = process_of(seen, "planner-left");
    return process && process->kind() == msg::ProcessEventKind::PROCESS_STARTED && process->pid() != pid;
  });
}

/// An arm with a standby planner on another host, which runs or not.
class HealthGoalOfTwo : public ::testing::Test {
 protected:
  void start_beta() { beta_.emplace(cell_.agent_command({"--host", "beta"})); }
  msg::CellStatus await_running(bool with_standby) {
    return cell_.await("a cell that runs", [&](const msg::CellStatus& status) {
      const msg::ArmStatus left = arm_of(status, "left");
      return left.state().mode() == msg::ArmMode::ARM_RUNNING && left.planner_alive() &&
             left.standby().empty() != with_standby && status.mode().mode() == msg::Mode::MODE_RUN &&
             arms_on(status.mode(), msg::Mode::MODE_HOLD).empty();
    });
  }
  void expect_arrival(const std::string& goal) {
    cell_.await_goal(goal,
                     [](const msg::GoalStatus& reported) { return reported.state() == msg::GoalState::GOAL_REACHED; });
    EXPECT_NEAR(cell_.next_state("left").q().at(0), 2.5, 1e-2);
  }
  HealthCell cell_{{"--host", "alpha"}, "standby_cell.yaml"};
  std::optional<ChildProcess> beta_;
};

// Either planner may be back first: the one that was in charge, or the standby.
TEST_F(HealthGoalOfTwo, SurvivesTheDeathOfBothPlanners) {
  start_beta();
  const auto status = await_running(true);
  const msg::ArmStatus before = arm_of(status, "left");
  const int in_charge = pid_of_node(status, before.planner());
  const int standing_by = pid_of_node(status, before.standby());
  ASSERT_NO_FATAL_FAILURE(send_and_leave(cell_, "left behind", "away"));
  // The planner publishes the status every 100 ms: by then the standby has received the first one.
  cell_.await_goal("left behind",
                   [](const msg::GoalStatus& reported) { return reported.state() == msg::GoalState::GOAL_ACTIVE; });
  ASSERT_TRUE(test::signal_process(in_charge, SIGKILL));
  ASSERT_TRUE(test::signal_process(standing_by, SIGKILL));
  expect_arrival("left behind");
  const msg::ArmStatus after = arm_of(await_running(true), "left");
  for (const std::string& planner : {after.planner(), after.standby()}) {
    const int pid = pid_of_node(await_running(true), planner);
    EXPECT_NE(pid, in_charge);
    EXPECT_NE(pid, standing_by);
  }
}

TEST_F(HealthGoalOfTwo, SurvivesThePlannerWithoutARunningStandby) {
  const auto status = await_running(false);
  const int pid = pid_of_node(status, arm_of(status, "left").planner());
  ASSERT_NO_FATAL_FAILURE(send_and_leave(cell_, "left alone", "away"));
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  expect_arrival("left alone");
}

}  // namespace
}  // namespace hecaton::services::testing
