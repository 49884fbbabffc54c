// Orders to a cell of real processes, and which of them survive the supervisor.

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "services/runtime/atomic_file.hpp"
#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

class HealthOrders : public ::testing::Test {
 protected:
  msg::SupervisorReply order(msg::RequestKind kind, const std::vector<std::string>& arms = {}) {
    const auto reply = cell_.call(kind, arms);
    EXPECT_TRUE(reply);
    return reply.value_or(msg::SupervisorReply());
  }
  HealthCell cell_;
};

TEST_F(HealthOrders, StatusDescribesTheWholeCell) {
  const auto status = cell_.await("arms that wait for a goal", [](const msg::CellStatus& seen) {
    return seen.has_contact_report() && seen.obstacles().size() == 1 && seen.arms().size() == 2 &&
           seen.arms()[0].waiting_for().text() == "a goal" && seen.arms()[1].waiting_for().text() == "a goal";
  });
  EXPECT_EQ(status.cell(), "health");
  EXPECT_EQ(status.supervisor(), "supervisor");
  EXPECT_GT(status.uptime(), 0.0);
  ASSERT_EQ(status.hosts().size(), 1U);
  EXPECT_EQ(status.hosts()[0].host(), "localhost");
  EXPECT_TRUE(status.hosts()[0].agent_alive());
  EXPECT_EQ(status.hosts()[0].processes().size(), 6U);
  const auto left = arm_of(status, "left");
  EXPECT_EQ(left.planner(), "planner/left");
  ASSERT_EQ(left.state().q().size(), 6U);
  EXPECT_NEAR(left.state().q()[1], -1.9, 1e-6);  // home, where it starts
  EXPECT_GE(left.state_age(), 0.0);
  EXPECT_EQ(status.obstacles()[0].shape(), "sphere ⌀ 0.2 m");
  EXPECT_EQ(status.obstacles()[0].motion(), "circle");
  EXPECT_EQ(status.contact_report().contacts(), 0U);
}

TEST_F(HealthOrders, StopIsLatchedUntilResume) {
  cell_.await_healthy();
  auto reply = order(msg::RequestKind::REQUEST_STOP);
  EXPECT_TRUE(reply.done());
  EXPECT_EQ(reply.status().mode().mode(), msg::Mode::MODE_STOP);
  EXPECT_EQ(arm_of(reply.status(), "left").mode(), msg::Mode::MODE_STOP);
  EXPECT_EQ(arm_of(reply.status(), "left").waiting_for().text(), "the cell is on stop by operator: waits for resume");
  reply = order(msg::RequestKind::REQUEST_HOLD);
  EXPECT_EQ(reply.status().mode().mode(), msg::Mode::MODE_STOP);
  reply = order(msg::RequestKind::REQUEST_RESUME, {"left"});
  EXPECT_FALSE(reply.done());
  EXPECT_EQ(reply.status().mode().mode(), msg::Mode::MODE_STOP);
  reply = order(msg::RequestKind::REQUEST_RESUME);
  EXPECT_TRUE(reply.done());
  EXPECT_EQ(reply.status().mode().mode(), msg::Mode::MODE_RUN);
  cell_.await_mode("run", [](const msg::CellMode& mode) { return mode.mode() == msg::Mode::MODE_RUN; });
}

TEST_F(HealthOrders, SingleArmsAreHeldAndResumed) {
  cell_.await_healthy();
  auto reply = order(msg::RequestKind::REQUEST_HOLD, {"left"});
  EXPECT_TRUE(reply.done());
  EXPECT_EQ(reply.status().mode().mode(), msg::Mode::MODE_RUN);
  EXPECT_EQ(arms_on(reply.status().mode(), msg::Mode::MODE_HOLD), std::vector<std::string>{"left"});
  reply = order(msg::RequestKind::REQUEST_STOP, {"right"});
  EXPECT_EQ(arms_on(reply.status().mode(), msg::Mode::MODE_STOP), std::vector<std::string>{"right"});
  reply = order(msg::RequestKind::REQUEST_RESUME, {"left"});
  EXPECT_TRUE(arms_on(reply.status().mode(), msg::Mode::MODE_HOLD).empty());
  EXPECT_EQ(arms_on(reply.status().mode(), msg::Mode::MODE_STOP), std::vector<std::string>{"right"});
}

TEST_F(HealthOrders, UnknownArmIsRejectedWithTheAllowedNames) {
  cell_.await_healthy();
  const auto reply = order(msg::RequestKind::REQUEST_HOLD, {"middle"});
  EXPECT_FALSE(reply.done());
  EXPECT_EQ(reply.cause().text(), "unknown arm middle: this cell's arms are left, right");
  EXPECT_EQ(reply.status().mode().mode(), msg::Mode::MODE_RUN);
  EXPECT_TRUE(arms_on(reply.status().mode(), msg::Mode::MODE_HOLD).empty());
}

TEST_F(HealthOrders, RestartedSupervisorLeadsUnderAHigherTermAndTheArmsContinue) {
  const auto before = cell_.await_healthy();
  const auto supervisor = process_of(before, "supervisor");
  ASSERT_TRUE(supervisor);
  cell_.send_goal("left", "g1", "turned");
  cell_.await("left moves", [](const msg::CellStatus& status) {
    return arm_of(status, "left").has_goal() && is_none(arm_of(status, "left").waiting_for());
  });
  ASSERT_TRUE(test::signal_process(supervisor->pid(), SIGKILL));

  const auto mode =
      cell_.await_mode("a higher term", [&](const msg::CellMode& seen) { return seen.term() > before.mode().term(); });
  EXPECT_EQ(mode.mode(), msg::Mode::MODE_RUN);
  cell_.await("left arrived", [](const msg::CellStatus& status) {
    return arm_of(status, "left").has_goal() && arm_of(status, "left").goal().goal() == "g1" &&
           arm_of(status, "left").goal().state() == msg::GoalState::GOAL_REACHED;
  });
  cell_.send_goal("right", "g2", "turned");
  const auto after = cell_.await("right executes orders under the new term", [](const msg::CellStatus& status) {
    return arm_of(status, "right").has_goal() && arm_of(status, "right").goal().state() == msg::GoalState::GOAL_REACHED;
  });
  EXPECT_GT(arm_of(after, "right").state().term(), before.mode().term());
  cell_.await("the predecessor's death is known", [](const msg::CellStatus& status) {
    for (const auto& fault : status.faults()) {
      if (fault.cause().kind() == msg::CauseKind::CAUSE_PROCESS_DIED && fault.cause().subject() == "supervisor" &&
          fault.cleared())
        return true;
    }
    return false;
  });
}

TEST_F(HealthOrders, StopSurvivesTheSupervisor) {
  const auto before = cell_.await_healthy();
  const auto supervisor = process_of(before, "supervisor");
  ASSERT_TRUE(supervisor);
  EXPECT_TRUE(order(msg::RequestKind::REQUEST_STOP).done());
  EXPECT_TRUE(order(msg::RequestKind::REQUEST_STOP, {"right"}).done());
  ASSERT_TRUE(test::signal_process(supervisor->pid(), SIGKILL));
  const auto mode =
      cell_.await_mode("a higher term", [&](const msg::CellMode& seen) { return seen.term() > before.mode().term(); });
  EXPECT_EQ(mode.mode(), msg::Mode::MODE_STOP);
  EXPECT_EQ(arms_on(mode, msg::Mode::MODE_STOP), std::vector<std::string>{"right"});
  const auto resumed = order(msg::RequestKind::REQUEST_RESUME).status().mode();
  EXPECT_EQ(resumed.mode(), msg::Mode::MODE_RUN);
  EXPECT_EQ(arms_on(resumed, msg::Mode::MODE_STOP), std::vector<std::string>{"right"}) << "it was stopped by name";
  const auto free = order(msg::RequestKind::REQUEST_RESUME, {"right"}).status().mode();
  EXPECT_TRUE(arms_on(free, msg::Mode::MODE_STOP).empty());
}

TEST_F(HealthOrders, FaultsSurviveTheSupervisor) {
  const auto before = cell_.await_healthy();
  ASSERT_TRUE(test::signal_process(process_of(before, "planner-left")->pid(), SIGKILL));
  const auto died = cell_.await_fault("death of planner/left", [](const msg::Fault& reported) {
    return reported.cause().subject() == "planner/left" &&
           reported.cause().kind() == msg::CauseKind::CAUSE_PROCESS_DIED && reported.cleared();
  });
  ASSERT_TRUE(test::signal_process(process_of(before, "supervisor")->pid(), SIGKILL));
  cell_.await_mode("a higher term", [&](const msg::CellMode& seen) { return seen.term() > before.mode().term(); });
  const auto after = cell_.await_healthy();
  const auto kept = std::find_if(after.faults().begin(), after.faults().end(),
                                 [&](const msg::Fault& fault) { return fault.id() == died.id(); });
  ASSERT_NE(kept, after.faults().end());
  EXPECT_EQ(kept->cause(), died.cause());
  EXPECT_EQ(kept->since_ns(), died.since_ns());
  EXPECT_EQ(kept->cleared_ns(), died.cleared_ns());
}

/// The value that an option has on a process's command line.
std::string option_of(int pid, const std::string& option) {
  std::ifstream line("/proc/" + std::to_string(pid) + "/cmdline");
  bool next = false;
  for (std::string word; std::getline(line, word, '\0'); next = word == option) {
    if (next) return word;
  }
  return {};
}

// A folder in the place of the checkpoint file makes every write fail.
TEST_F(HealthOrders, OrdersAreExecutedAndTheFailureReportedWithoutACheckpoint) {
  const int pid = process_of(cell_.await_healthy(), "supervisor")->pid();
  const std::string checkpoint = option_of(pid, "--checkpoint");
  ASSERT_FALSE(checkpoint.empty());
  const std::string next = spare_file_of(checkpoint);
  // Repeated if the supervisor writes just then.
  for (std::error_code error; !std::filesystem::create_directory(next, error);) std::filesystem::remove(next, error);
  const auto reply = order(msg::RequestKind::REQUEST_STOP);
  EXPECT_TRUE(reply.done());
  EXPECT_NE(reply.cause().text().find(checkpoint + " cannot be written"), std::string::npos) << reply.cause().text();
  EXPECT_EQ(reply.status().mode().mode(), msg::Mode::MODE_STOP);
  const auto is_degraded = [](const msg::CellStatus& status) {
    return std::any_of(status.nodes().begin(), status.nodes().end(), [](const msg::NodeStatus& node) {
      return node.heartbeat().node() == "supervisor" && node.heartbeat().state() == msg::NodeState::NODE_DEGRADED;
    });
  };
  const auto degraded = cell_.await("a degraded supervisor", is_degraded);
  EXPECT_EQ(open_faults(degraded, "persistence_failed", "supervisor"), 1) << text_of(degraded);
  ASSERT_TRUE(std::filesystem::remove(next));
  cell_.await("a checkpoint that is written again", [&](const msg::CellStatus& status) {
    return !is_degraded(status) && open_faults(status, "persistence_failed", "supervisor") == 0;
  });
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  const auto after = cell_.await("its successor", [&](const msg::CellStatus& status) {
    return status.mode().term() > reply.status().mode().term();
  });
  EXPECT_EQ(after.mode().mode(), msg::Mode::MODE_STOP);
}

}  // namespace
}  // namespace hecaton::services::testing
