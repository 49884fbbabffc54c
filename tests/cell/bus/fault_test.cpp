// Processes that die or hang, observed over the bus only. The participants' lease is a minute, so the topic's lease
// detects them.
#include <algorithm>
#include <memory>
#include <vector>

#include <idl/arm.h>
#include <idl/health.h>

#include "tests/cell/bus/peer_process.hpp"
#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::bus {
namespace {

class Faults : public testing::Test {
 protected:
  static PeerOptions long_lease_peer() { return {.lease_ms = 60'000}; }
  static ParticipantOptions long_lease() {
    auto options = one_host();
    options.lease = 60s;
    return options;
  }

  /// Waits for the first event of a kind about a key; collects those about other keys in others_.
  template <class T>
  [[nodiscard]] std::optional<Event> wait_event(Reader<T>& reader, EventKind kind, const std::string& key) {
    std::optional<Event> found;
    [[maybe_unused]] const bool in_time = wait_until(reader, [&] {
      for (const auto& event : reader.mailbox().take_events()) {
        if (event.kind != kind) continue;
        if (event.key == key) {
          found = event;
        } else {
          others_.push_back(event);
        }
      }
      return found.has_value();
    });
    return found;
  }

  template <class T>
  void expect_heard(Reader<T>& reader, std::initializer_list<const char*> keys) {
    ASSERT_TRUE(wait_until(reader, [&] {
      return std::all_of(keys.begin(), keys.end(), [&](const char* key) { return reader.latest(key) != nullptr; });
    }));
  }

  test::FreeDomain domain_;
  Participant here_{domain_.number(), "supervisor", long_lease()};
  std::vector<Event> others_;
};

TEST_F(Faults, DetectsAKilledProcessWhileOthersLive) {
  Reader<msg::Heartbeat> reader(here_);
  PeerProcess alive("heartbeat", domain_.number(), "alive", long_lease_peer());
  PeerProcess also("heartbeat", domain_.number(), "also-alive", long_lease_peer());
  for (int round = 0; round < 5; ++round) {
    const std::string name = "victim" + std::to_string(round);
    PeerProcess victim("heartbeat", domain_.number(), name, long_lease_peer());
    expect_heard(reader, {name.c_str(), "alive", "also-alive"});
    const auto killed = Clock::now();
    victim.kill();
    const auto event = wait_event(reader, EventKind::kDeadlineMissed, name);
    ASSERT_TRUE(event) << name;
    std::printf("kill -9 detected by the deadline of 20 ms after %.1f ms\n",
                std::chrono::duration<double, std::milli>(event->at - killed).count());
  }
  // Samples of the living processes still arrive, and none of the dead.
  const auto now = Clock::now();
  ASSERT_TRUE(wait_until(reader, [&] {
    const auto* sample = reader.latest("alive");
    return sample != nullptr && sample->received > now;
  }));
  EXPECT_LT(reader.latest("victim0")->received, now);
}

// Enough samples, writers and rounds for the thread of timers to handle a writer while it is destroyed.
TEST_F(Faults, DestroysWritersWhoseReaderDiedWithoutAcknowledging) {
  constexpr int kRounds = 30;
  constexpr int kWriters = 20;
  constexpr int kSamples = 250;
  for (int round = 0; round < kRounds; ++round) {
    PeerProcess victim("gather", domain_.number(), "victim", long_lease_peer());
    ::testing::internal::CaptureStderr();
    {
      std::vector<std::unique_ptr<Writer<msg::ProcessEvent>>> writers;
      for (int i = 0; i < kWriters; ++i) writers.push_back(std::make_unique<Writer<msg::ProcessEvent>>(here_));
      // One reader of each earlier victim is still known, because the participants' lease is a minute.
      for (const auto& writer : writers) EXPECT_TRUE(writer->wait_matched(round + 1, kPatience));
      victim.kill();
      for (const auto& writer : writers) {
        msg::ProcessEvent event;
        for (int i = 0; i < kSamples; ++i) {
          event.process("victim/" + std::to_string(i));
          EXPECT_TRUE(writer->write(event));
        }
      }
    }
    ASSERT_EQ(::testing::internal::GetCapturedStderr(), "") << "a removal has deadlocked in round " << round;
  }
}

TEST_F(Faults, DetectsAStoppedProcessByItsDeadline) {
  Reader<msg::ArmState> reader(here_);
  PeerProcess busy("heartbeat", domain_.number(), "busy", long_lease_peer());
  PeerProcess hung("heartbeat", domain_.number(), "hung", long_lease_peer());
  expect_heard(reader, {"busy", "hung"});
  for (int round = 0; round < 5; ++round) {
    [[maybe_unused]] const auto before = reader.mailbox().take_events();
    const auto paused = Clock::now();
    hung.send(SIGSTOP);
    const auto event = wait_event(reader, EventKind::kDeadlineMissed, "hung");
    ASSERT_TRUE(event);
    std::printf("SIGSTOP detected by the deadline of 20 ms after %.1f ms\n",
                std::chrono::duration<double, std::milli>(event->at - paused).count());
    hung.send(SIGCONT);
    const auto resumed = Clock::now();
    ASSERT_TRUE(wait_until(reader, [&] { return reader.latest("hung")->received > resumed; }));
  }
}

// A stopped reader received nothing for longer than the deadline, which is no fault of its writers.
TEST_F(Faults, ReportsNoMissedDeadlinesAfterAStopOfTheReader) {
  PeerProcess speaker("heartbeat", domain_.number(), "speaker", long_lease_peer());
  PeerProcess listener("listen", domain_.number(), "listener", long_lease_peer());
  Reader<msg::ArmState> reader(here_);
  expect_heard(reader, {"speaker"});
  std::string line = listener.line();
  while (line.find("at ") != 0) line = listener.line();
  listener.send(SIGSTOP);
  const auto stopped_at = reader.latest("speaker")->value.sequence_number();
  ASSERT_TRUE(wait_until(reader, [&] {  // 2 s of its states
    return reader.latest("speaker")->value.sequence_number() > stopped_at + 400;
  }));
  listener.send(SIGCONT);
  while (line.find("at ") != 0 || std::stoull(line.substr(3)) < stopped_at + 600) {
    line = listener.line();
    ASSERT_NE(line, "silent");
    ASSERT_FALSE(line.empty()) << "the listener has ended";
  }
}

TEST_F(Faults, ReceivesTheStandbyWhenThePrimaryIsKilled) {
  Reader<msg::ArmCommand> reader(here_);
  PeerProcess standby("command", domain_.number(), "standby", long_lease_peer());
  PeerProcess primary("command", domain_.number(), "primary", long_lease_peer());
  const auto received_from = [&](const std::string& node, Clock::time_point since) {
    return wait_until(reader, [&] {
      const auto* sample = reader.latest("arm1");
      return sample != nullptr && sample->value.node() == node && sample->received > since;
    });
  };
  ASSERT_TRUE(reader.wait_matched(2, kPatience));
  ASSERT_TRUE(received_from("primary", Clock::now()));
  primary.kill();
  const auto killed = Clock::now();
  ASSERT_TRUE(received_from("standby", killed));
  std::printf("standby received %.1f ms after kill -9 of the primary\n",
              std::chrono::duration<double, std::milli>(reader.latest("arm1")->received - killed).count());
}

TEST_F(Faults, GivesALateSupervisorAllProcessEvents) {
  PeerProcess agent("process", domain_.number(), "host1");
  PeerProcess other("process", domain_.number(), "host2");
  ASSERT_EQ(agent.line(), "ready");
  ASSERT_EQ(other.line(), "ready");
  Reader<msg::ProcessEvent> reader(here_);
  EXPECT_TRUE(wait_until(reader, [&] { return reader.latest().size() == 60; })) << reader.latest().size();
}

}  // namespace
}  // namespace hecaton::bus
