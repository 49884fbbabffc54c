// An intruder in a cell with its real supervisors: it ends no supervision and moves no arm.
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/runtime/node_name.hpp"
#include "tests/cell/supervision/health_cell.hpp"

namespace hecaton::services::testing {
namespace {

class SupervisedIntruder : public ::testing::Test {
 protected:
  void SetUp() override { await_running(); }

  /// Until both arms run and the supervisor leads.
  void await_running() {
    const auto status = cell_.await("arms that run", [](const msg::CellStatus& seen) {
      return seen.mode().mode() == msg::Mode::MODE_RUN && arms_on(seen.mode(), msg::Mode::MODE_HOLD).empty() &&
             std::all_of(seen.arms().begin(), seen.arms().end(), [](const msg::ArmStatus& arm) {
               return arm.state().mode() == msg::ArmMode::ARM_RUNNING && !arm.planner().empty();
             });
    });
    term_ = status.mode().term();
    lease_ = arm_of(status, "left").term();
    planner_ = arm_of(status, "left").planner();
  }

  /// Attacks for this long, and returns the greatest term of a cell mode meanwhile.
  template <class Attack>
  std::uint64_t greatest_term(bus::Clock::duration duration, Attack attack) {
    std::uint64_t greatest = 0;
    for (const auto until = bus::Clock::now() + duration; bus::Clock::now() < until;) {
      attack();
      static_cast<void>(modes_.wait_for_data(10ms));
      for (const auto& sample : modes_.take()) greatest = std::max(greatest, sample.value.term());
    }
    return greatest;
  }

  HealthCell cell_;
  bus::Participant intruder_ = [this] {
    bus::ParticipantOptions options;
    options.interfaces = {"127.0.0.1"};
    options.partition = "*";
    return bus::Participant(cell_.domain(), "intruder", options);
  }();
  bus::Reader<msg::CellMode> modes_{intruder_};
  std::uint64_t term_ = 0;
  std::uint64_t lease_ = 0;
  std::string planner_;
};

TEST_F(SupervisedIntruder, DeposesNoSupervisorByTermsInTheNameOfANode) {
  bus::Writer<msg::Heartbeat> heartbeats(intruder_);
  bus::Writer<msg::ArmState> states(intruder_);
  ASSERT_TRUE(heartbeats.wait_matched(1, kPatience));
  ASSERT_TRUE(states.wait_matched(1, kPatience));
  std::uint64_t number = 0;
  const auto greatest = greatest_term(3s, [&] {
    for (const std::string& node : {std::string("x"), agent_node("localhost"), world_node(), driver_node("left"),
                                    planner_, planner_node("none")}) {
      msg::Heartbeat heartbeat;
      heartbeat.node(node);
      heartbeat.kind(msg::NodeKind::NODE_PLANNER);
      heartbeat.subject("left");
      heartbeat.host("h");
      heartbeat.term(term_ + 1);
      heartbeat.lease().arm("left");
      heartbeat.lease().planner("x");
      heartbeat.lease().term(lease_ + 1);
      heartbeat.sequence_number(++number);
      ASSERT_TRUE(heartbeats.write(heartbeat));
    }
    for (const char* arm : {"left", "none"}) {
      msg::ArmState state;
      state.arm(arm);
      state.newest_term(term_ + 1);
      state.sequence_number(++number);
      ASSERT_TRUE(states.write(state));
    }
  });
  EXPECT_EQ(greatest, term_) << "a supervisor that was deposed leads under another term";
}

// An arm follows no participant that takes a greater term by itself.
TEST_F(SupervisedIntruder, MovesNoArmWhileTheSupervisorIsSilent) {
  bus::Writer<msg::ArmCommand> commands(intruder_);
  ASSERT_TRUE(commands.wait_matched(1, kPatience));
  const msg::ArmState before = cell_.next_state("left");
  const auto status = cell_.await("the supervisor", [](const msg::CellStatus&) { return true; });
  const int supervisor = pid_of_node(status, supervisor_node());
  ASSERT_EQ(kill(supervisor, SIGSTOP), 0);
  msg::ArmCommand command;
  command.arm("left");
  command.period(0.01);
  command.q(before.q());
  command.q()[0] += 0.05;
  command.qd(std::vector<double>(before.q().size(), 0.0));
  for (const auto until = bus::Clock::now() + 2s; bus::Clock::now() < until;) {
    for (const std::string& node : {planner_, std::string("x")}) {
      command.node(node);
      command.term(lease_ + 2);
      command.sequence_number(command.sequence_number() + 1);
      ASSERT_TRUE(commands.write(command));
    }
    const msg::ArmState state = cell_.next_state("left");
    EXPECT_EQ(state.newest_term(), lease_);
    EXPECT_NEAR(state.q()[0], before.q()[0], 1e-3);
  }
  ASSERT_EQ(kill(supervisor, SIGCONT), 0);
  await_running();
}

}  // namespace
}  // namespace hecaton::services::testing
