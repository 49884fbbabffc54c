// The end of a cell: no process is left, whether the agent is terminated or killed; its checkpoints stay for the next
// agent.

#include <algorithm>
#include <chrono>
#include <csignal>

#include <gtest/gtest.h>
#include <poll.h>

#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

TEST(HealthEnd, TerminatedAgentEndsItsServicesAndReturnsZero) {
  HealthCell cell;
  const CellProcesses processes(cell.await_healthy());
  ASSERT_EQ(processes.count(), 6U);
  cell.agent().signal(SIGTERM);
  const auto end = cell.await_end();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 0);
  EXPECT_EQ(end->signal_number, 0);
  EXPECT_TRUE(processes.await_all_ended());
}

TEST(HealthEnd, StoppedServiceDoesNotPreventTheAgentFromEnding) {
  HealthCell cell;
  const auto status = cell.await_healthy();
  const CellProcesses processes(status);
  ASSERT_TRUE(test::signal_process(process_of(status, "driver-left")->pid(), SIGSTOP));
  cell.agent().signal(SIGINT);
  const auto end = cell.await_end();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 0);
  EXPECT_TRUE(processes.await_all_ended());
}

TEST(HealthEnd, KilledAgentEndsItsServices) {
  HealthCell cell;
  const CellProcesses processes(cell.await_healthy());
  cell.agent().signal(SIGKILL);
  ASSERT_TRUE(cell.await_end());
  EXPECT_TRUE(processes.await_all_ended());
}

class HealthSuccessor : public ::testing::Test {
 protected:
  /// Stops the cell, removes its ball and kills its agent. Returns the cell term.
  std::uint64_t stop_edit_and_kill() {
    cell_.await_healthy();
    const auto reply = cell_.call(msg::RequestKind::REQUEST_STOP);
    EXPECT_TRUE(reply && reply->done());
    msg::WorldEditRequest edit;
    edit.kind(msg::EditKind::EDIT_REMOVE);
    edit.name("ball");
    edit.X_WO().qw(1.0);
    EXPECT_TRUE(cell_.edit(edit).done());
    const auto status = cell_.await("no ball", [](const auto& seen) { return seen.obstacles().empty(); });
    const CellProcesses processes(status);
    cell_.agent().signal(SIGKILL);
    EXPECT_TRUE(cell_.await_end());
    EXPECT_TRUE(processes.await_all_ended());
    return status.mode().term();
  }
  /// Status of a supervisor that leads under a higher term, once all nodes are alive.
  msg::CellStatus await_successors(std::uint64_t term) {
    return cell_.await("a cell of other processes", [&](const msg::CellStatus& status) {
      const auto& nodes = status.nodes();
      return status.mode().term() > term && status.has_contact_report() && nodes.size() == 7 &&
             std::all_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.alive(); });
    });
  }
  HealthCell cell_;
};

TEST_F(HealthSuccessor, OfAKilledAgentContinuesWithOrdersAndEdits) {
  const std::uint64_t term = stop_edit_and_kill();
  const ChildProcess next(cell_.agent_command({}));
  const auto status = await_successors(term);
  EXPECT_TRUE(status.mode().mode() == msg::Mode::MODE_STOP) << text_of(status);
  EXPECT_TRUE(status.obstacles().empty());
}

TEST_F(HealthSuccessor, WithCleanDiscardsOrdersAndEdits) {
  static_cast<void>(stop_edit_and_kill());
  const ChildProcess next(cell_.agent_command({"--clean"}));
  const auto status = cell_.await("the ball", [](const auto& seen) { return seen.obstacles().size() == 1; });
  EXPECT_TRUE(status.mode().mode() != msg::Mode::MODE_STOP) << text_of(status);
}

TEST(HealthEnd, SecondAgentOfAHostIsRejected) {
  HealthCell cell;
  cell.await_healthy();
  ChildProcess second(cell.agent_command({"--host", "localhost"}));
  pollfd ended{second.fd(), POLLIN, 0};
  ASSERT_EQ(poll(&ended, 1, static_cast<int>(std::chrono::milliseconds(kPatience).count())), 1);
  EXPECT_EQ(second.poll_end()->exit_code, 3);
  cell.await_healthy();
}

TEST(HealthEnd, UnknownHostIsBadInput) {
  HealthCell cell({"--host", "elsewhere"});
  const auto end = cell.await_end();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 3);
}

}  // namespace
}  // namespace hecaton::services::testing
