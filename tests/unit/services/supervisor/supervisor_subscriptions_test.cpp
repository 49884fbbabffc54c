// Reception of samples: past process events for late joiners, heartbeats, states and rows.
#include "services/supervisor/supervisor_subscriptions.hpp"

#include "services/runtime/node_name.hpp"
#include "tests/unit/services/bus/bus_test.hpp"
#include "tests/unit/services/supervisor/detection/virtual_cell.hpp"

namespace hecaton::services {
namespace {

using testing::cell_limits;
using testing::cell_nodes;

/// An agent that has published an exit and its successor, and another exit without one.
class PastEvents : public bus::BusTest {
 protected:
  void SetUp() override {
    die("driver/arm1", 11);
    start("driver/arm1", 12);
    die("driver/arm2", 21);
  }

  void die(const std::string& node, int pid, const std::string& reason = {}) {
    tell(node, pid, msg::ProcessEventKind::PROCESS_EXITED, 9, reason);
  }
  void start(const std::string& node, int pid) { tell(node, pid, msg::ProcessEventKind::PROCESS_STARTED, 0); }

  void tell(const std::string& node, int pid, msg::ProcessEventKind kind, int signal, const std::string& reason = {}) {
    msg::ProcessEvent event;
    event.process("h1/" + node);
    event.host("h1");
    event.node(node);
    event.pid(pid);
    event.kind(kind);
    event.signal_number(signal);
    if (!reason.empty()) event.cause(make_cause(msg::CauseKind::CAUSE_NODE_SILENT, event.node(), reason));
    event.sequence_number(++told_);
    event.stamp_ns(std::chrono::nanoseconds(std::chrono::seconds(told_)).count());
    ASSERT_TRUE(events_.write(event));
  }

  void heartbeat() {
    msg::Heartbeat heartbeat;
    heartbeat.node(agent_node("h1"));
    heartbeat.kind(msg::NodeKind::NODE_AGENT);
    heartbeat.host("h1");
    heartbeat.newest_event(told_);
    heartbeat.stamp_ns(std::chrono::nanoseconds(std::chrono::seconds(60)).count());
    ASSERT_TRUE(beats_.write(heartbeat));
  }

  bus::Writer<msg::ProcessEvent> events_{here_};
  bus::Writer<msg::Heartbeat> beats_{here_};
  std::uint64_t told_ = 0;
};

/// A supervisor's subscriptions and its detector.
struct Listener {
  explicit Listener(bus::Participant& participant, bool remembers, std::vector<ExpectedNode> nodes = cell_nodes(),
                    const std::string& host = {})
      : watch(std::move(nodes), {"arm1", "arm2", "arm3"}, cell_limits(), bus::Clock::now().time_since_epoch(), host),
        ears(participant, {"supervisor", "h1", remembers}, mailbox, mailbox),
        own(participant) {}

  void receive() {
    watch.advance(bus::Clock::now().time_since_epoch());
    static_cast<void>(mailbox.take_events());
    ears.receive(own.id(), {snapshot, watch, leadership, succession});
  }
  /// Receives until the event of this number has arrived; calls `meanwhile` repeatedly.
  template <class Act>
  [[nodiscard]] bool hears(std::uint64_t number, Act meanwhile) {
    const auto heard = [&] {
      return std::any_of(snapshot.processes.begin(), snapshot.processes.end(),
                         [&](const auto& entry) { return entry.second.value.sequence_number() == number; });
    };
    for (const auto until = bus::Clock::now() + bus::kPatience; !heard() && bus::Clock::now() < until; receive()) {
      meanwhile();
      static_cast<void>(mailbox.wait(bus::kOnceMore));
    }
    return heard();
  }
  /// Sends repeatedly until the only open fault is this one, or, without a subject, there is none.
  template <class Send>
  [[nodiscard]] bool reports(const std::string& subject, msg::CauseKind kind, Send send) {
    for (const auto until = bus::Clock::now() + bus::kPatience; bus::Clock::now() < until; receive()) {
      if (!send()) return false;
      static_cast<void>(mailbox.wait(cell_limits().loop_period));
      const auto names = faulty();
      if (subject.empty() ? names.empty() : names == std::vector<std::string>{subject}) {
        return subject.empty() || watch.faults().open().front().kind == kind;
      }
    }
    return false;
  }
  [[nodiscard]] std::vector<std::string> faulty() {
    watch.judge(bus::Clock::now().time_since_epoch());
    std::vector<std::string> subjects;
    for (const FaultRecord& fault : watch.faults().open()) subjects.push_back(fault.subject);
    return subjects;
  }

  bus::Mailbox mailbox;
  CellSnapshot snapshot;
  FaultDetector watch;
  Leadership leadership{{}, 0, bus::Clock::now().time_since_epoch()};
  PlannerFailover succession{{}};
  SupervisorSubscriptions ears;
  bus::Writer<msg::CellMode> own;
};

using Subjects = std::vector<std::string>;

TEST_F(PastEvents, AreNoFaultsWithoutACheckpointUnlessTheyLast) {
  Listener newcomer(there_, false);
  ASSERT_TRUE(newcomer.hears(3, [&] { heartbeat(); }));
  EXPECT_EQ(newcomer.faulty(), Subjects{"driver/arm2"});
  die("driver/arm1", 12);
  start("driver/arm1", 13);
  ASSERT_TRUE(newcomer.hears(5, [] {}));
  EXPECT_EQ(newcomer.faulty(), (Subjects{"driver/arm2", "driver/arm1"})) << "a new exit, although its successor runs";
}

// The supervisor reports the end of its predecessor itself.
TEST_F(PastEvents, AreNoFaultsOfTheOwnNode) {
  Listener successor(there_, true);
  ASSERT_TRUE(successor.hears(3, [&] { heartbeat(); }));
  die("supervisor", 41);
  die("ros2", 51);
  ASSERT_TRUE(successor.hears(5, [] {}));
  const Subjects subjects = successor.faulty();
  EXPECT_EQ(std::count(subjects.begin(), subjects.end(), "supervisor"), 0);
  EXPECT_EQ(std::count(subjects.begin(), subjects.end(), "ros2"), 1) << "a helper";
}

// Of two heartbeats within a turn each counts.
TEST_F(PastEvents, HeartbeatsOfTwoProcessesOfOneNodeAreBothReceived) {
  Listener listener(there_, false);
  bus::Writer<msg::Heartbeat> second(here_);
  bus::Reader<msg::Heartbeat> probe(there_);
  ASSERT_TRUE(probe.wait_matched(2, bus::kPatience));
  const auto is_told = [&] {
    const auto open = listener.watch.faults().open();
    return std::any_of(open.begin(), open.end(),
                       [](const auto& one) { return one.kind == msg::CauseKind::CAUSE_DUPLICATE_NODE; });
  };
  const auto heartbeat = [](bus::Writer<msg::Heartbeat>& by, const std::string& node, int pid, std::uint64_t number) {
    msg::Heartbeat sample;
    sample.node(node);
    sample.kind(msg::NodeKind::NODE_PLANNER);
    sample.host("h1");
    sample.pid(pid);
    sample.sequence_number(number);
    return by.write(sample);
  };
  // The first samples may be lost: discovery may have matched one side only.
  const auto arrives = [&](const std::string& node, std::uint64_t number) {
    for (const auto until = bus::Clock::now() + bus::kOnceMore; bus::Clock::now() < until;) {
      static_cast<void>(probe.wait_for_data(until - bus::Clock::now()));
      for (const auto& sample : probe.take()) {
        if (sample.value.node() == node && sample.value.sequence_number() == number) return;
      }
    }
  };
  for (std::uint64_t turn = 1; turn <= 100 && !is_told(); ++turn) {
    ASSERT_TRUE(heartbeat(beats_, "planner/arm1", 1, turn));
    ASSERT_TRUE(heartbeat(second, "planner/arm1", 2, turn));
    // Earlier samples have reached every reader.
    ASSERT_TRUE(heartbeat(second, "planner/arm2", 3, turn));
    arrives("planner/arm2", turn);
    listener.receive();
    static_cast<void>(listener.faulty());
  }
  EXPECT_TRUE(is_told());
}

TEST_F(PastEvents, NodeFailureWithoutTextIsAFault) {
  Listener listener(there_, false);
  msg::Heartbeat sample;
  sample.node("planner/arm3");
  sample.kind(msg::NodeKind::NODE_PLANNER);
  sample.host("h2");
  sample.state(msg::NodeState::NODE_FAILED);
  EXPECT_TRUE(
      listener.reports("planner/arm3", msg::CauseKind::CAUSE_NODE_FAILED, [&] { return beats_.write(sample); }));
}

// No other supervisor takes such a term: the orders of a forged mode must not replace those of people.
TEST_F(PastEvents, TakesNoOrdersFromACellModeOfItsOwnTerms) {
  Listener listener(there_, false);
  bus::Writer<msg::CellMode> forged(here_);
  msg::CellMode mode;
  mode.term(7);
  mode.node("supervisor");
  for (const auto until = bus::Clock::now() + bus::kPatience;
       listener.leadership.highest() < 7 && bus::Clock::now() < until; listener.receive()) {
    ASSERT_TRUE(forged.write(mode));
    static_cast<void>(listener.mailbox.wait(cell_limits().loop_period));
  }
  EXPECT_EQ(listener.leadership.highest(), 7U);
  EXPECT_FALSE(listener.ears.leader_mode());
  EXPECT_FALSE(listener.leadership.hears_leader());
}

TEST_F(PastEvents, DeviceFailureIsAFaultOfItsArm) {
  Listener listener(there_, false);
  bus::Writer<msg::ArmState> states(here_);
  msg::ArmState sample;
  sample.arm("arm1");
  sample.mode(msg::ArmMode::ARM_FAILED);
  sample.cause(make_cause(msg::CauseKind::CAUSE_DEVICE_FAILED, "arm1", "joint 3: overcurrent"));
  EXPECT_TRUE(listener.reports("arm1", msg::CauseKind::CAUSE_ARM_FAILED, [&] { return states.write(sample); }));
  sample.mode(msg::ArmMode::ARM_RUNNING);
  sample.cause({});
  EXPECT_TRUE(listener.reports("", {}, [&] { return states.write(sample); }));
}

// The rows of h1 and h2 say that neither has heard the listener's host.
TEST_F(PastEvents, RowsShowThatTheOwnHostIsNotHeard) {
  Listener listener(there_, false, testing::nodes_of_three_hosts(), "h3");
  bus::Writer<msg::Reachability> rows(here_);
  const auto write = [&](float age) {
    for (const char* host : {"h1", "h2", "h3"}) {
      msg::Reachability row;
      row.host(host);
      for (const char* other : {"h1", "h2", "h3"}) {
        if (std::string(other) == host) continue;
        row.heard().emplace_back();
        row.heard().back().host(other);
        row.heard().back().age(std::string(other) == "h3" ? age : 0.005F);
      }
      if (!rows.write(row)) return false;
    }
    return true;
  };
  EXPECT_TRUE(listener.reports("", {}, [&] { return write(0.005F); }));
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(write(0.005F));
    static_cast<void>(listener.mailbox.wait(cell_limits().loop_period));
    listener.receive();
  }
  EXPECT_TRUE(listener.reports("h3", msg::CauseKind::CAUSE_HOST_ISOLATED, [&] { return write(0.2F); }));
}

TEST_F(PastEvents, WaitForTheFirstHeartbeatOfTheirAgent) {
  Listener newcomer(there_, false);
  // A younger reader of the same participant: its samples have reached the newcomer, too.
  bus::Reader<msg::ProcessEvent> probe(there_);
  ASSERT_TRUE(bus::wait_until(probe, [&] {
    static_cast<void>(probe.take());
    return probe.latest().size() == 2;
  }));
  newcomer.receive();
  EXPECT_EQ(newcomer.faulty(), Subjects{});
  EXPECT_TRUE(newcomer.hears(3, [&] { heartbeat(); }));
}

TEST_F(PastEvents, AreFaultsOfTheirOwnTimeWithACheckpoint) {
  Listener successor(there_, true);
  ASSERT_TRUE(successor.hears(3, [&] { heartbeat(); }));
  const Time now = bus::Clock::now().time_since_epoch();
  EXPECT_EQ(successor.faulty(), (Subjects{"driver/arm1", "driver/arm2"}));
  for (const FaultRecord& fault : successor.watch.faults().open()) {
    EXPECT_LT(fault.since, now - std::chrono::seconds(56))
        << "1 s and 3 s by the agent's clock, 60 s at its first heartbeat";
    EXPECT_FALSE(fault.detection_latency_bound);
  }
}

TEST_F(PastEvents, NameTheAgentAndItsReasonForAKill) {
  die("driver/arm3", 31, "its loop was silent for 10012 ms");
  Listener newcomer(there_, false);
  ASSERT_TRUE(newcomer.hears(4, [&] { heartbeat(); }));
  EXPECT_EQ(newcomer.faulty(), (Subjects{"driver/arm2", "driver/arm3"}));
  std::vector<std::string> seen;
  for (const FaultRecord& fault : newcomer.watch.faults().open()) seen.push_back(fault.description);
  EXPECT_EQ(seen,
            (std::vector<std::string>{"driver/arm2: process 21 was ended by signal 9 (Killed)",
                                      "driver/arm3: its agent ended process 31: its loop was silent for 10012 ms"}));
}

}  // namespace
}  // namespace hecaton::services
