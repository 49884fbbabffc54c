// Faults in a cell of real processes: processes are killed and stopped, and the supervisor publishes what it observes.

#include <algorithm>
#include <csignal>

#include <gtest/gtest.h>

#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

int pid_of(const msg::CellStatus& status, const std::string& name) {
  const auto process = process_of(status, name);
  EXPECT_TRUE(process) << name;
  return process ? process->pid() : 0;
}

bool fault_is(const msg::Fault& fault, const std::string& kind, const std::string& subject, bool cleared) {
  return cause_name(fault.cause().kind()) == kind && fault.cause().subject() == subject && fault.cleared() == cleared;
}

TEST(HealthFaults, KilledPlannerIsAFaultUntilItsSuccessorRuns) {
  HealthCell cell;
  const auto before = cell.await_healthy();
  const int pid = pid_of(before, "planner-left");
  ASSERT_GT(pid, 0);
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));

  const auto fault = cell.await_fault("death of planner/left", [](const msg::Fault& reported) {
    return fault_is(reported, "process_died", "planner/left", false);
  });
  EXPECT_EQ(fault.cause().text(), "planner/left: process " + std::to_string(pid) + " was ended by signal 9 (Killed)");
  EXPECT_EQ(fault.severity(), msg::Severity::SEVERITY_ERROR);
  cell.await_mode("left is held", [](const msg::CellMode& mode) {
    return contains(arms_on(mode, msg::Mode::MODE_HOLD), "left") &&
           !contains(arms_on(mode, msg::Mode::MODE_HOLD), "right") && mode.mode() == msg::Mode::MODE_RUN &&
           causes_text(mode).find("signal 9") != std::string::npos;
  });

  const auto cleared = cell.await_fault("end of that fault", [](const msg::Fault& reported) {
    return fault_is(reported, "process_died", "planner/left", true);
  });
  EXPECT_EQ(cleared.id(), fault.id());
  const auto after = cell.await_healthy();
  EXPECT_NE(pid_of(after, "planner-left"), pid);
  EXPECT_EQ(process_of(after, "planner-left")->restarts(), 1U);
  EXPECT_EQ(process_of(after, "planner-right")->restarts(), 0U);
}

TEST(HealthFaults, StoppedPlannerIsSilentUntilItContinues) {
  HealthCell cell;
  const int pid = pid_of(cell.await_healthy(), "planner-right");
  ASSERT_GT(pid, 0);
  ASSERT_TRUE(test::signal_process(pid, SIGSTOP));
  const auto fault = cell.await_fault("silence of planner/right", [](const msg::Fault& reported) {
    return fault_is(reported, "node_silent", "planner/right", false);
  });
  const auto held = cell.await("right is held, with its cause", [](const msg::CellStatus& status) {
    const auto arm = arm_of(status, "right");
    return arm.mode() == msg::Mode::MODE_HOLD && !arm.planner_alive() && arm.driver_alive() &&
           arm.waiting_for().text().starts_with("held: planner/right: no heartbeat for more than ");
  });
  EXPECT_EQ(arm_of(held, "left").mode(), msg::Mode::MODE_RUN);
  EXPECT_EQ(open_faults(held, "node_silent", "planner/right"), 1);

  ASSERT_TRUE(test::signal_process(pid, SIGCONT));
  const auto cleared = cell.await_fault("end of the silence", [](const msg::Fault& reported) {
    return fault_is(reported, "node_silent", "planner/right", true);
  });
  EXPECT_EQ(cleared.id(), fault.id());
  EXPECT_EQ(pid_of(cell.await_healthy(), "planner-right"), pid);
}

TEST(HealthFaults, StoppedDriverIsOneFault) {
  HealthCell cell;
  const int pid = pid_of(cell.await_healthy(), "driver-left");
  ASSERT_GT(pid, 0);
  ASSERT_TRUE(test::signal_process(pid, SIGSTOP));
  const auto status = cell.await("driver/left is lost", [](const msg::CellStatus& seen) {
    return open_faults(seen, "node_silent", "driver/left") == 1 &&
           seen.faults().front().severity() == msg::Severity::SEVERITY_ERROR;
  });
  EXPECT_EQ(open_faults(status, "driver_silent", "left"), 0);
  EXPECT_TRUE(contains(arms_on(status.mode(), msg::Mode::MODE_HOLD), "left"));
  ASSERT_TRUE(test::signal_process(pid, SIGCONT));
  cell.await_healthy();
}

TEST(HealthFaults, KilledWorldHoldsTheCellUntilItsSuccessorRuns) {
  HealthCell cell;
  const int pid = pid_of(cell.await_healthy(), "world");
  ASSERT_GT(pid, 0);
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  cell.await_mode("the cell is held", [](const msg::CellMode& mode) {
    return mode.mode() == msg::Mode::MODE_HOLD && causes_text(mode).starts_with("world: process ");
  });
  cell.await_mode("the cell runs again", [](const msg::CellMode& mode) { return mode.mode() == msg::Mode::MODE_RUN; });
  const auto status = cell.await_healthy();
  ASSERT_EQ(status.obstacles().size(), 1U);
  EXPECT_EQ(status.obstacles().front().name(), "ball");
}

TEST(HealthFaults, FaultStaysWithoutRestart) {
  HealthCell cell({"--no-restart"});
  const int pid = pid_of(cell.await_healthy(), "driver-right");
  ASSERT_GT(pid, 0);
  ASSERT_TRUE(test::signal_process(pid, SIGTERM));
  cell.await("the agent reports the service", [](const msg::CellStatus& status) {
    for (const auto& node : status.nodes()) {
      if (node.heartbeat().kind() == msg::NodeKind::NODE_AGENT &&
          node.heartbeat().state() == msg::NodeState::NODE_DEGRADED) {
        return node.heartbeat().cause().text() == "driver-right ended and is not restarted" &&
               open_faults(status, "process_died", "driver/right") == 1 &&
               contains(arms_on(status.mode(), msg::Mode::MODE_HOLD), "right");
      }
    }
    return false;
  });
}

TEST(HealthFaults, OtherArmPlansAroundAnArmWhoseDriverDied) {
  HealthCell cell({"--no-restart"}, "lost_arm_cell.yaml");
  const int pid = pid_of(cell.await_healthy(), "driver-right");
  ASSERT_GT(pid, 0);
  // Where an arm is lost is known only from a state that the supervisor has received.
  static_cast<void>(cell.await("the supervisor knows where right is", [](const msg::CellStatus& seen) {
    return std::any_of(seen.arms().begin(), seen.arms().end(),
                       [](const msg::ArmStatus& arm) { return arm.arm() == "right" && arm.state().q().size() == 6U; });
  }));
  cell.send_goal("right", "under way", "turned");
  cell.await_goal("under way",
                  [](const msg::GoalStatus& reported) { return reported.state() == msg::GoalState::GOAL_ACTIVE; });
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  const auto mode = cell.await_mode("right is lost", [](const msg::CellMode& reported) {
    return reported.lost_arms().size() == 1 && contains(arms_on(reported, msg::Mode::MODE_HOLD), "right");
  });
  EXPECT_EQ(mode.lost_arms().front().arm(), "right");
  EXPECT_EQ(mode.lost_arms().front().q().size(), 6U);
  EXPECT_NEAR(mode.lost_arms().front().braking_delay_bound(), 0.07, 1e-9)
      << "the command timeout and the margin for lost states";

  for (const char* named : {"turned", "home"}) {
    cell.send_goal("left", named, named);
    cell.await_goal(named,
                    [](const msg::GoalStatus& reported) { return reported.state() == msg::GoalState::GOAL_REACHED; });
  }
  const auto status = cell.await("left's planner runs", [](const msg::CellStatus& seen) {
    return seen.has_contact_report() &&
           std::any_of(seen.nodes().begin(), seen.nodes().end(), [](const msg::NodeStatus& node) {
             return node.heartbeat().node() == "planner/left" &&
                    node.heartbeat().state() == msg::NodeState::NODE_RUNNING;
           });
  });
  EXPECT_EQ(status.contact_report().contacts(), 0U);
}

TEST(HealthFaults, SecondProcessOfANodeIsAFaultUntilItEnds) {
  HealthCell cell;
  const int pid = pid_of(cell.await_healthy(), "planner-left");
  bus::Writer<msg::Heartbeat> second(cell.participant());
  const auto is = [](const msg::Fault& reported, bool cleared) {
    return fault_is(reported, "duplicate_node", "planner/left", cleared);
  };
  bus::Reader<msg::Fault> faults(cell.participant(), &cell.mailbox());
  msg::Heartbeat heartbeat;
  heartbeat.node("planner/left");
  heartbeat.kind(msg::NodeKind::NODE_PLANNER);
  heartbeat.host("localhost");
  heartbeat.pid(1);
  std::string seen;
  for (const auto until = bus::Clock::now() + kPatience; seen.empty() && bus::Clock::now() < until;) {
    heartbeat.sequence_number(heartbeat.sequence_number() + 1);
    ASSERT_TRUE(second.write(heartbeat));
    static_cast<void>(cell.mailbox().wait(10ms));
    static_cast<void>(cell.mailbox().take_events());
    for (const auto& sample : faults.take()) {
      if (!sample.disposed && is(sample.value, false)) seen = sample.value.cause().text();
    }
  }
  EXPECT_NE(seen.find("processes 1 and " + std::to_string(pid)), std::string::npos) << seen;
  cell.await_fault("its end", [&](const msg::Fault& reported) { return is(reported, true); });
  cell.await_healthy();
}

}  // namespace
}  // namespace hecaton::services::testing
