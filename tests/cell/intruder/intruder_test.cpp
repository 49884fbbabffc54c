// An intruder in a live cell: each attack, and that the arm goes on and the attack is named. Without keys an intruder
// can still join; what it then cannot do is the subject here (docs/explanation/security.md).
#include "tests/cell/intruder/intruder.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/bus/type_support.hpp"
#include "services/runtime/cause.hpp"
#include "tests/cell/motion/motion_cell.hpp"
#include "tests/support/rtps_datagram.hpp"

namespace hecaton::test {
namespace {

constexpr std::uint64_t kLast = std::numeric_limits<std::uint64_t>::max();

class IntruderCell : public MotionCell {
 protected:
  IntruderCell()
      : MotionCell(1,
                   "  - {name: post, shapes: [{type: box, size: [0.1, 0.1, 0.1]}], "
                   "pose: {xyz: [-0.6, 0, 0.3]}}\n") {}

  void SetUp() override {
    start_all();
    bus::ParticipantOptions options;
    options.interfaces = {"127.0.0.1"};
    options.partition = "*";
    intruder_ = std::make_unique<bus::Participant>(domain_.number(), "intruder", options);
    ASSERT_TRUE(await(
        [this] { return arm() != nullptr && arm()->term() == 1 && !arm()->planner().empty() && !arm()->q().empty(); }));
    state_ = *arm();
  }

  /// Repeats the attack while the arm goes to a goal. The arm arrives, and no state is anything but a measured one.
  void withstand(const std::function<void()>& attack) {
    history_.clear();
    const std::string id = "goal" + std::to_string(++goals_sent_);
    send(joint_goal(id, goals_sent_ % 2 == 0 ? kHome : kReady));
    EXPECT_TRUE(await([&] {
      attack();
      return is(id, msg::GoalState::GOAL_REACHED);
    })) << "the arm does not arrive";
    for (const msg::ArmState& state : history_) {
      ASSERT_TRUE(std::all_of(state.q().begin(), state.q().end(), [](double q) { return std::abs(q) < 7.0; }));
      ASSERT_LE(state.newest_term(), 1U);
    }
  }

  /// The node's heartbeat tells of a refusal of this kind, with the sender's name, GUID and address.
  void expect_named(const std::string& node, msg::CauseKind kind, const std::string& text,
                    const std::string& topic = "ArmCommand") {
    std::string all;
    EXPECT_TRUE(await([&] {
      const auto& refusals = alive_[node].refusals();
      return std::any_of(refusals.begin(), refusals.end(), [&](const msg::Refusal& refusal) {
        const bool is_it = refusal.cause().kind() == kind && refusal.topic() == topic &&
                           refusal.cause().text().find(text) != std::string::npos;
        all += refusal.cause().subject() + " " + refusal.cause().text() + " " + refusal.address() + "\n";
        return is_it && refusal.sender().size() == 32 && !refusal.address().empty() && refusal.count() > 0;
      });
    })) << node
        << " does not name \"" << text << "\":\n"
        << all.substr(0, 2000);
  }

  /// A command as the planner would give it, by the last state of the arm.
  [[nodiscard]] msg::ArmCommand command() {
    if (arm() != nullptr) state_ = *arm();
    msg::ArmCommand message;
    message.arm("arm1");
    message.node(state_.planner());
    message.term(state_.term());
    message.sequence_number(state_.command_sequence_number() + 1);
    message.period(0.01);
    message.q(state_.q());
    message.qd(std::vector<double>(6, 0.0));
    return message;
  }

  template <class T>
  [[nodiscard]] bus::Writer<T> forger() {
    bus::Writer<T> writer(*intruder_);
    EXPECT_TRUE(writer.wait_matched(1, kLimit));
    return writer;
  }

  std::unique_ptr<bus::Participant> intruder_;
  msg::ArmState state_;
  int goals_sent_ = 0;
};

TEST_F(IntruderCell, DoesNotMoveTheArmByForgedCommands) {
  auto writer = forger<msg::ArmCommand>();
  const auto forge = [&](const std::function<void(msg::ArmCommand&)>& change) {
    return [this, &writer, change] {
      msg::ArmCommand message = command();
      change(message);
      (void)writer.write(message);
    };
  };
  withstand(forge([](auto& message) {
    message.period(1.7e308);
    message.qd(std::vector<double>(6, -1.5));
  }));
  expect_named("driver/arm1", msg::CauseKind::CAUSE_INPUT_REFUSED, "period = 1.7e+308");
  withstand(forge([](auto& message) { message.period(5.0); }));
  withstand(forge([](auto& message) { message.q()[2] = std::nan(""); }));
  expect_named("driver/arm1", msg::CauseKind::CAUSE_INPUT_REFUSED, "q[2] = nan");
  withstand(forge([](auto& message) { message.sequence_number(kLast - 1); }));
  expect_named("driver/arm1", msg::CauseKind::CAUSE_INPUT_REFUSED, "sequence_number");
  withstand(forge([](auto& message) { message.sequence_number(std::uint64_t{1} << 52U); }));
  withstand(forge([](auto& message) { message.term(kLast); }));
  expect_named("driver/arm1", msg::CauseKind::CAUSE_INPUT_REFUSED, "term = 18446744073709551615");
  // The driver reports such commands once they have lasted for a second, which may be longer than one motion.
  for (int i = 0; i < 3; ++i) withstand(forge([](auto& message) { message.term(1000); }));
  expect_named("driver/arm1", msg::CauseKind::CAUSE_INPUT_REFUSED, "has granted only 1");
  withstand(forge([](auto& message) { message.term(message.term() + 1); }));
  withstand(forge([](auto& message) { message.q()[0] += 0.3; }));
  expect_named("driver/arm1", msg::CauseKind::CAUSE_SECOND_WRITER, "two participants command the arm");
}

TEST_F(IntruderCell, DoesNotStopTheCellByForgedModes) {
  auto writer = forger<msg::CellMode>();
  msg::CellMode mode = mode_;
  mode.term(kLast);
  mode.mode(msg::Mode::MODE_STOP);
  withstand([&] { (void)writer.write(mode); });
  expect_named("driver/arm1", msg::CauseKind::CAUSE_INPUT_REFUSED, "term = 18446744073709551615", "CellMode");
  mode.term(std::uint64_t{1} << 40U);
  withstand([&] { (void)writer.write(mode); });
  mode.term(mode_.term() - 1);
  withstand([&] { (void)writer.write(mode); });
  mode.term(mode_.term());
  withstand([&] {
    set_mode(msg::Mode::MODE_RUN, mode_.term());
    (void)writer.write(mode);
  });
  expect_named("driver/arm1", msg::CauseKind::CAUSE_SECOND_WRITER, "a second participant writes it", "CellMode");
}

TEST_F(IntruderCell, IsNotBelievedWhereTheArmAndTheObstaclesAre) {
  auto states = forger<msg::ArmState>();
  withstand([&] {
    if (arm() != nullptr) state_ = *arm();
    msg::ArmState state = state_;
    state.q()[0] += 1.0;
    state.sequence_number(state.sequence_number() + 1000);
    (void)states.write(state);
  });
  expect_named("planner/arm1", msg::CauseKind::CAUSE_SECOND_WRITER, "intruder writes it, too", "ArmState");
  auto obstacles = forger<msg::ObstacleStates>();
  auto shapes = forger<msg::ObstacleShapes>();
  msg::ObstacleShapes sphere;
  sphere.name("post");
  sphere.obstacle(box("post", 0.0, 0.0, 0.0));
  sphere.obstacle().shapes()[0].kind(msg::ShapeKind::SHAPE_SPHERE);
  sphere.obstacle().shapes()[0].dimensions().x(2.0);
  sphere.obstacle().shapes()[0].dimensions().y(0.0);
  sphere.obstacle().shapes()[0].dimensions().z(0.0);
  msg::ObstacleStates moved;
  moved.states().emplace_back().name("post");
  moved.sequence_number(1U << 30U);
  withstand([&] {
    (void)shapes.write(sphere);
    (void)obstacles.write(moved);
  });
  expect_named("planner/arm1", msg::CauseKind::CAUSE_SECOND_WRITER, "intruder writes it, too", "ObstacleStates");
}

TEST_F(IntruderCell, TakesNoMemoryBySamplesThatClaimIt) {
  const auto header = [](const char* arm) {
    msg::ArmCommand message = msg::ArmCommand();
    message.arm(arm);
    return message;
  };
  RawParticipant raw(domain_.number());
  RawWriter commands(raw, "*", "ArmCommand");
  ASSERT_TRUE(await([&] { return commands.matched(); }));
  msg::ArmCommand many = header("arm1");
  many.q(std::vector<double>(100'000, 0.1));
  const std::string large = bus::GuardedType<msg::ArmCommand>().bytes_of(many);
  std::string claimed = bus::GuardedType<msg::ArmCommand>().bytes_of(header("arm1"));
  std::fill(claimed.end() - 8, claimed.end(), '\xFF');
  ASSERT_TRUE(await([&] { return alive_["driver/arm1"].rss_bytes() > 0; }));
  const auto before = alive_["driver/arm1"].rss_bytes();
  withstand([&] {
    commands.write(large);
    commands.write(claimed);
    commands.write(std::string("\x00\x07\xFF", 3));
  });
  expect_named("driver/arm1", msg::CauseKind::CAUSE_INPUT_REFUSED, "");
  EXPECT_LT(alive_["driver/arm1"].rss_bytes(), before + (20U << 20U));
}

bus::ParticipantOptions on_this_host() {
  bus::ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  return options;
}

/// A reader of commands, and an intruder beside it.
struct LoneReader {
  FreeDomain domain;
  bus::Participant participant{domain.number(), "reader", on_this_host()};
  bus::Reader<msg::ArmCommand> reader{participant};
  RawParticipant raw{domain.number()};
};

TEST(Incompatible, WriterIsReportedWithItsPolicy) {
  LoneReader alone;
  auto& reader = alone.reader;
  const RawWriter writer(alone.raw, "*", "ArmCommand", {.reliable = false});
  std::string policy;
  const auto end = bus::Clock::now() + std::chrono::seconds(30);
  while (policy.empty() && bus::Clock::now() < end) {
    static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(100)));
    for (const bus::Event& event : reader.mailbox().take_events()) {
      if (event.kind == bus::EventKind::kIncompatible) policy = event.key;
    }
  }
  EXPECT_EQ(policy, "reliability");
  EXPECT_EQ(reader.matched(), 0);
}

// The intruder chooses names and instance handles. While it stays, Fast DDS takes no new key: it keeps the instances of
// living writers.
TEST(ManyKeys, TakeNoMemoryAndOpenNoStreamOfOthers) {
  constexpr std::size_t kKeys = 5000;
  constexpr auto kMost = static_cast<std::size_t>(bus::Topic<msg::ArmState>::kInfo.qos.instances);
  LoneReader alone;
  bus::Reader<msg::ArmState> reader(alone.participant);
  bus::Participant driver(alone.domain.number(), "driver", on_this_host());
  bus::Writer<msg::ArmState> states(driver);
  RawWriter forged(alone.raw, "*", "ArmState", {.reliable = false}, true, true);
  msg::ArmState north;
  north.arm("north");
  const auto end = bus::Clock::now() + kLimit;
  /// Until the newest sample of this arm is its driver's.
  const auto reads = [&](const msg::ArmState& state, bus::Writer<msg::ArmState>& writer) {
    while (bus::Clock::now() < end) {
      static_cast<void>(writer.write(state));
      static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(20)));
      const auto* newest = reader.latest(state.arm());
      if (newest != nullptr && newest->writer == writer.id()) return true;
    }
    return false;
  };
  ASSERT_TRUE(reads(north, states));
  while (!forged.matched() && bus::Clock::now() < end) ASSERT_TRUE(reads(north, states));
  const auto bytes_of = [](const std::string& arm) {
    msg::ArmState state;
    state.arm(arm);
    return bus::GuardedType<msg::ArmState>().bytes_of(state);
  };
  for (std::size_t i = 0; i < kKeys; ++i) {
    forged.write(bytes_of("x" + std::to_string(i)), 1);  // many names, one handle
    if (i % 16 != 0) continue;
    static_cast<void>(states.write(north));
    ASSERT_LE(reader.latest().size(), kMost);
  }
  EXPECT_EQ(reader.latest().size(), kMost) << "so many have arrived";
  for (int i = 0; i < 50; ++i) {
    static_cast<void>(states.write(north));
    forged.write(bytes_of("north"), 2);
    static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(5)));
    const auto* newest = reader.latest("north");
    ASSERT_NE(newest, nullptr);
    EXPECT_EQ(newest->writer, states.id()) << "the stream has a second writer";
  }
  for (std::size_t i = 0; i < kKeys; ++i) forged.write(bytes_of("x"), i + 3);  // one name, many handles
  EXPECT_TRUE(reads(north, states));
  EXPECT_LE(reader.latest().size(), kMost);
}

// The reader would look for 2³² samples, which takes its participant a minute.
TEST(AnnouncedWriter, DoesNotHangItsReaderByHeartbeats) {
  LoneReader alone;
  auto& reader = alone.reader;
  const RawWriter announced(alone.raw, "*", "ArmCommand");
  RtpsDatagram::Prefix prefix{};
  const auto guid = announced.guid();
  std::copy_n(guid.begin(), prefix.size(), prefix.begin());
  std::uint32_t entity = 0;
  for (std::size_t i = prefix.size(); i < guid.size(); ++i) entity = entity << 8U | guid[i];
  const DatagramSender sender(alone.domain.number());
  const auto end = bus::Clock::now() + kLimit;
  while (reader.matched() == 0 && bus::Clock::now() < end) {
    sender.send(RtpsDatagram(prefix).acknowledgement(1, 0).bytes());  // its socket belongs to the participant, too
    static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(20)));
  }
  ASSERT_EQ(reader.matched(), 1);

  const auto claims = [&](std::int64_t last, std::uint32_t count) {
    sender.send(RtpsDatagram(prefix).writer(entity).heartbeat(1, last, count).bytes());
  };
  const std::string why = "a heartbeat lists more than 1048576 samples";
  const auto is_named = [&] {
    const auto refused = alone.participant.refused(kLimit, 8);
    return std::any_of(refused.begin(), refused.end(), [&](const bus::Refused& one) { return one.text == why; });
  };
  std::uint32_t count = 1000;
  while (!is_named() && bus::Clock::now() < end) {
    claims(std::int64_t{1} << 32, ++count);
    static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(20)));
  }
  EXPECT_TRUE(is_named());
  claims(std::int64_t{1} << 20, ++count);  // the most that is accepted

  bus::Participant peer(alone.domain.number(), "planner", on_this_host());
  bus::Writer<msg::ArmCommand> commands(peer);
  msg::ArmCommand command;
  command.arm("arm1");
  bool received = false;
  while (!received && bus::Clock::now() < end) {
    static_cast<void>(commands.write(command));
    static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(20)));
    for (const auto& sample : reader.take()) received = received || sample.writer == commands.id();
  }
  EXPECT_TRUE(received);
}

TEST_F(IntruderCell, DoesNotHangAProcessByDatagrams) {
  const DatagramSender sender(domain_.number());
  const auto guid = states_.latest("arm1")->writer;  // of the driver
  RtpsDatagram::Prefix driver{};
  std::copy_n(guid.bytes.begin(), driver.size(), driver.begin());
  constexpr std::int64_t kHuge = std::int64_t{1} << 62;
  withstand([&] {
    for (const std::uint32_t entity : {0x000002C2U, 0x00000102U, 0x00000103U, 0x000003C2U, 0x000004C2U, 0x000100C2U}) {
      sender.send(RtpsDatagram(driver).writer(entity).heartbeat(kHuge, kHuge).bytes());
      sender.send(RtpsDatagram(driver).writer(entity).gap(1, 2'000'000'000).bytes());
      sender.send(RtpsDatagram(driver).writer(entity).gap(1, 1'000'000).bytes());
      sender.send(RtpsDatagram(driver).writer(entity).data(kHuge).bytes());
      sender.send(RtpsDatagram(driver).writer(entity).fragment(1, 1, 1, 60'000, 0xFFFFFFFF).bytes());
    }
  });
  expect_named("planner/arm1", msg::CauseKind::CAUSE_INPUT_REFUSED, "", "");
}

TEST_F(IntruderCell, SurvivesMalformedDatagrams) {
  const DatagramSender sender(domain_.number());
  std::mt19937_64 random(11);
  const auto model = RtpsDatagram().data(1).heartbeat(1, 2).gap(1, 3).fragment(2, 1, 1, 100, 300).bytes();
  withstand([&] {
    for (int i = 0; i < 200; ++i) {
      auto bytes = model;
      for (int flips = 0; flips < 4; ++flips) {
        bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
      }
      bytes.resize(random() % (bytes.size() + 1));
      sender.send(bytes);
    }
  });
}

}  // namespace
}  // namespace hecaton::test
