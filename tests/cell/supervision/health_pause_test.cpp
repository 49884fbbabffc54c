// A process is stopped for longer than its participant's lease and then continues. Discovery matches it again, no old
// command moves an arm, and every fault ends.

#include <csignal>

#include <gtest/gtest.h>

#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

class HealthPause : public ::testing::Test {
 protected:
  /// Stops the process until all peers have dropped it.
  int stop(const std::string& process, const std::string& node) {
    const auto found = process_of(cell_.await_healthy(), process);
    EXPECT_TRUE(found);
    if (!found) return 0;
    EXPECT_TRUE(test::signal_process(found->pid(), SIGSTOP));
    cell_.await_dropped(node);
    return found->pid();
  }
  void send_left_on_its_way() {
    cell_.await_healthy();
    cell_.send_goal("left", "way", "away");
    cell_.await("left moves", [](const msg::CellStatus& status) {
      return arm_of(status, "left").has_goal() && is_none(arm_of(status, "left").waiting_for());
    });
  }
  void expect_arrival() {
    cell_.await_goal("way",
                     [](const msg::GoalStatus& status) { return status.state() == msg::GoalState::GOAL_REACHED; });
  }
  /// The fault, once the cell is healthy again.
  msg::Fault fault_that_is_over(const std::string& kind, const std::string& subject) {
    const auto status = cell_.await_healthy();
    for (const msg::Fault& fault : status.faults()) {
      if (cause_name(fault.cause().kind()) == kind && fault.cause().subject() == subject && fault.cleared())
        return fault;
    }
    ADD_FAILURE() << "no " << kind << " of " << subject << " was published:\n" << text_of(status);
    return {};
  }
  HealthCell cell_;
};

TEST_F(HealthPause, PlannerContinuesItsGoal) {
  send_left_on_its_way();
  const int pid = stop("planner-left", "planner/left");
  const auto held = cell_.next_state("left");
  EXPECT_EQ(held.mode(), msg::ArmMode::ARM_STOPPED);
  ASSERT_TRUE(test::signal_process(pid, SIGCONT));
  expect_arrival();
  const msg::Fault fault = fault_that_is_over("node_silent", "planner/left");
  EXPECT_TRUE(fault.cause().text().starts_with("planner/left: no heartbeat for more than ")) << fault.cause().text();
  EXPECT_EQ(process_of(cell_.await_healthy(), "planner-left")->pid(), pid);
}

TEST_F(HealthPause, DriverStandsStillUntilANewCommand) {
  send_left_on_its_way();
  const int pid = stop("driver-left", "driver/left");
  ASSERT_TRUE(test::signal_process(pid, SIGCONT));
  // The simulated arm braked as if its commands had ceased. Old commands in its socket did not move it.
  const auto first = cell_.next_state("left");
  EXPECT_EQ(first.mode(), msg::ArmMode::ARM_STOPPED) << first.cause().text();
  for (const double speed : first.qd()) EXPECT_EQ(speed, 0.0);
  expect_arrival();
  static_cast<void>(fault_that_is_over("node_silent", "driver/left"));
  EXPECT_EQ(process_of(cell_.await_healthy(), "driver-left")->pid(), pid);
}

TEST_F(HealthPause, WorldContinuesAtItsOwnTime) {
  const auto before = cell_.await("a report", [](const msg::CellStatus& seen) { return seen.has_contact_report(); });
  const int pid = stop("world", "world");
  ASSERT_TRUE(test::signal_process(pid, SIGCONT));
  static_cast<void>(fault_that_is_over("node_silent", "world"));
  const auto after = cell_.await("another report", [&](const msg::CellStatus& seen) {
    return seen.contact_report().time() > before.contact_report().time() && seen.contact_report_age() < 1.0;
  });
  EXPECT_EQ(process_of(after, "world")->pid(), pid);
  ASSERT_EQ(after.obstacles().size(), 1U);
  EXPECT_LT(after.obstacles()[0].age(), 1.0);
  cell_.send_goal("left", "way", "away");
  expect_arrival();
}

TEST_F(HealthPause, SupervisorReportsNoOtherNodeForItsOwnAbsence) {
  const auto before = cell_.await_healthy();
  cell_.send_goal("left", "way", "away");
  const int pid = stop("supervisor", "supervisor");
  expect_arrival();  // arms continue without the supervisor
  ASSERT_TRUE(test::signal_process(pid, SIGCONT));
  cell_.await_mode("a new term", [&](const msg::CellMode& mode) { return mode.term() > before.mode().term(); });
  const msg::Fault own = fault_that_is_over("node_silent", "supervisor");
  EXPECT_TRUE(own.cause().text().starts_with("supervisor: was itself stopped and away for ")) << own.cause().text();
  const auto after = cell_.await_healthy();
  for (const msg::Fault& fault : after.faults()) {
    const bool of_that_time = fault.since_ns() >= own.since_ns() && fault.since_ns() <= own.cleared_ns();
    EXPECT_TRUE(fault.id() == own.id() || !of_that_time) << fault.cause().text();
  }
  EXPECT_EQ(process_of(after, "supervisor")->pid(), pid);
  cell_.send_goal("right", "way", "away");
  cell_.await_goal("way", [](const msg::GoalStatus& status) {
    return status.arm() == "right" && status.state() == msg::GoalState::GOAL_REACHED;
  });
}

// The stop is too short for peers to drop the supervisor.
TEST_F(HealthPause, SupervisorReportsItsOwnStall) {
  const auto before = cell_.await_healthy();
  const int pid = process_of(before, "supervisor")->pid();
  ASSERT_TRUE(test::signal_process(pid, SIGSTOP));
  const auto begin = cell_.next_state("left").stamp_ns();
  while (cell_.next_state("left").stamp_ns() - begin < 500'000'000) {
  }
  ASSERT_TRUE(test::signal_process(pid, SIGCONT));
  const msg::Fault own = fault_that_is_over("node_silent", "supervisor");
  EXPECT_TRUE(own.cause().text().starts_with("supervisor: stood still for ")) << own.cause().text();
  EXPECT_EQ(process_of(cell_.await_healthy(), "supervisor")->pid(), pid);
}

TEST_F(HealthPause, AgentReturnsWithItsServices) {
  const auto before = cell_.await_healthy();
  ASSERT_TRUE(test::signal_process(cell_.agent().pid(), SIGSTOP));
  cell_.await_dropped("agent/localhost");
  cell_.await("agent/localhost is a fault",
              [](const msg::CellStatus& status) { return open_faults(status, "node_silent", "agent/localhost") == 1; });
  ASSERT_TRUE(test::signal_process(cell_.agent().pid(), SIGCONT));
  static_cast<void>(fault_that_is_over("node_silent", "agent/localhost"));
  const auto after = cell_.await_healthy();
  for (const auto& process : before.hosts()[0].processes()) {
    EXPECT_EQ(process_of(after, process.name())->pid(), process.pid());
  }
}

}  // namespace
}  // namespace hecaton::services::testing
