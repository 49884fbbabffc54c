// A planner dies on its arm's way to a goal that nobody will give again.

#include <csignal>
#include <optional>

#include <gtest/gtest.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/join.hpp"
#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

/// Gives a goal, stays until its arm is on the way, and leaves.
void give_and_leave(HealthCell& cell, const std::string& goal, const std::string& named) {
  ServiceOptions options;
  options.domain = cell.domain();
  bus::Mailbox mailbox;
  bus::Participant participant = make_participant(cell.file(), options, "guest", &mailbox);
  bus::Writer<msg::Goal> goals(participant);
  msg::Goal message;
  message.arm("left");
  message.goal(goal);
  message.client("guest");
  message.sequence_number(1);
  message.kind(msg::GoalKind::GOAL_NAMED);
  message.named(named);
  ASSERT_TRUE(goals.write(message));
  cell.await_goal(goal, [](const msg::GoalStatus& told) { return told.state() == msg::GoalState::GOAL_ACTIVE; });
}

TEST(HealthGoal, OfAGuestThatHasLeftOutlivesThePlanner) {
  HealthCell cell;
  const int pid = pid_of_node(cell.await_healthy(), "planner/left");
  ASSERT_NO_FATAL_FAILURE(give_and_leave(cell, "left behind", "away"));
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  cell.await_goal("left behind",
                  [](const msg::GoalStatus& told) { return told.state() == msg::GoalState::GOAL_REACHED; });
  EXPECT_NEAR(cell.next_state("left").q().at(0), 2.5, 1e-2);
  cell.await("another planner", [&](const msg::CellStatus& seen) {
    const auto process = process_of(seen, "planner-left");
    return process && process->kind() == msg::ProcessEventKind::PROCESS_STARTED && process->pid() != pid;
  });
}

/// An arm whose planner has a standby on another host, which is up or not.
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
    cell_.await_goal(goal, [](const msg::GoalStatus& told) { return told.state() == msg::GoalState::GOAL_REACHED; });
    EXPECT_NEAR(cell_.next_state("left").q().at(0), 2.5, 1e-2);
  }
  HealthCell cell_{{"--host", "alpha"}, "standby_cell.yaml"};
  std::optional<ChildProcess> beta_;
};

// Whoever is back first: the one that was in charge, or the one that stood by and is put in its place.
TEST_F(HealthGoalOfTwo, OutlivesBothPlanners) {
  start_beta();
  const auto status = await_running(true);
  const msg::ArmStatus before = arm_of(status, "left");
  const int in_charge = pid_of_node(status, before.planner());
  const int standing_by = pid_of_node(status, before.standby());
  ASSERT_NO_FATAL_FAILURE(give_and_leave(cell_, "left behind", "away"));
  // It is told every 100 ms: by then the other has heard the first word of it, in its next period.
  cell_.await_goal("left behind",
                   [](const msg::GoalStatus& told) { return told.state() == msg::GoalState::GOAL_ACTIVE; });
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

TEST_F(HealthGoalOfTwo, OutlivesThePlannerWhileTheStandbyIsNotThere) {
  const auto status = await_running(false);
  const int pid = pid_of_node(status, arm_of(status, "left").planner());
  ASSERT_NO_FATAL_FAILURE(give_and_leave(cell_, "left alone", "away"));
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  expect_arrival("left alone");
}

}  // namespace
}  // namespace hecaton::services::testing
