// An intruder in a cell with its real supervisors: it ends no supervision and moves no arm.
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <string>
#include <thread>
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

// The supervisor leads on above each forged term, carries out orders meanwhile, and keeps them.
TEST_F(SupervisedIntruder, DeposesNoSupervisorByCellModes) {
  bus::Writer<msg::CellMode> forged(intruder_);
  ASSERT_TRUE(forged.wait_matched(1, kPatience));
  std::jthread attack([&](const std::stop_token& stop) {
    std::uint64_t greatest = term_;
    msg::CellMode mode;
    mode.node(supervisor_node());
    while (!stop.stop_requested()) {
      static_cast<void>(modes_.wait_for_data(10ms));
      for (const auto& sample : modes_.take()) greatest = std::max(greatest, sample.value.term());
      mode.term(greatest);
      mode.sequence_number(mode.sequence_number() + 1);
      static_cast<void>(forged.write(mode));
    }
  });
  for (int i = 0; i < 3; ++i) {
    const auto stopped = cell_.call(msg::RequestKind::REQUEST_STOP);
    ASSERT_TRUE(stopped && stopped->done());
    const auto status = cell_.call(msg::RequestKind::REQUEST_STATUS);
    ASSERT_TRUE(status);
    EXPECT_EQ(status->status().mode().mode(), msg::Mode::MODE_STOP) << "a forged mode does not resume the cell";
    const auto resumed = cell_.call(msg::RequestKind::REQUEST_RESUME);
    ASSERT_TRUE(resumed && resumed->done());
  }
  attack.request_stop();
  attack.join();
  await_running();
}

// A reader refuses a message that is too long: then no order would reach an arm, and no answer a client.
TEST_F(SupervisedIntruder, HidesNoOrderBehindLongTexts) {
  bus::Writer<msg::Heartbeat> heartbeats(intruder_);
  bus::Writer<msg::ObstacleShapes> shapes(intruder_);
  ASSERT_TRUE(heartbeats.wait_matched(1, kPatience));
  ASSERT_TRUE(shapes.wait_matched(1, kPatience));
  const auto status = cell_.await("the supervisor", [](const msg::CellStatus&) { return true; });
  msg::Heartbeat heartbeat;
  heartbeat.host("localhost");
  heartbeat.state(msg::NodeState::NODE_FAILED);
  heartbeat.cause(make_cause(msg::CauseKind::CAUSE_NODE_FAILED, "left", std::string(16'384, 'x')));
  const auto speak = [&](const std::string& node) {
    heartbeat.node(node);
    heartbeat.sequence_number(heartbeat.sequence_number() + 1);
    ASSERT_TRUE(heartbeats.write(heartbeat));
  };
  for (int i = 0; i < 300; ++i) speak("helper" + std::to_string(i));
  msg::ObstacleShapes forged;
  forged.obstacle().attached_to("left");
  for (int i = 0; i < 300; ++i) {
    forged.name(std::string(150, 'o') + std::to_string(i));
    forged.obstacle().name(forged.name());
    ASSERT_TRUE(shapes.write(forged));
  }
  heartbeat.pid(pid_of_node(status, driver_node("left")));
  speak(driver_node("left"));
  const auto stopped = cell_.call(msg::RequestKind::REQUEST_STOP);
  ASSERT_TRUE(stopped && stopped->done()) << "the answer reaches its client";
  static_cast<void>(cell_.await_mode("stop", [&](const msg::CellMode& mode) {
    speak(driver_node("left"));
    return mode.mode() == msg::Mode::MODE_STOP;
  }));
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
