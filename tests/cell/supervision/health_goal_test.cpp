// A planner dies on its arm's way to a goal that nobody will give again.

#include <csignal>

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
  message.kind(msg::GOAL_NAMED);
  message.named(named);
  ASSERT_TRUE(goals.write(message));
  cell.await_goal(goal, [](const msg::GoalStatus& told) { return told.state() == msg::GOAL_ACTIVE; });
}

TEST(HealthGoal, OfAGuestThatHasLeftOutlivesThePlanner) {
  HealthCell cell;
  const int pid = pid_of_node(cell.await_healthy(), "planner/left");
  ASSERT_NO_FATAL_FAILURE(give_and_leave(cell, "left behind", "away"));
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  cell.await_goal("left behind", [](const msg::GoalStatus& told) { return told.state() == msg::GOAL_REACHED; });
  EXPECT_NEAR(cell.next_state("left").q().at(0), 2.5, 1e-2);
  cell.await("another planner", [&](const msg::CellStatus& seen) {
    const auto process = process_of(seen, "planner-left");
    return process && process->kind() == msg::PROCESS_STARTED && process->pid() != pid;
  });
}

}  // namespace
}  // namespace hecaton::services::testing
