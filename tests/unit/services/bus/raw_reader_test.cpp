/// Samples as bytes, checked as typed readers check them.

#include "services/bus/raw_reader.hpp"

#include <idl/arm.h>
#include <idl/goal.h>

#include "services/bus/type_support.hpp"
#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::bus {
namespace {

constexpr std::size_t kRoom = std::size_t{1} << 20U;

template <class T>
std::size_t index_of() {
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    if (kTopics[i].type == Topic<T>::kInfo.type) return i;
  }
  return kTopics.size();
}

msg::ArmState state(std::uint64_t sequence_number, const std::string& arm = "north") {
  msg::ArmState state;
  state.arm(arm);
  state.sequence_number(sequence_number);
  state.q({0.1, 0.2});
  return state;
}

class RawBus : public BusTest {
 protected:
  /// Waits for samples until `done()` holds, which may write more.
  template <class Condition>
  [[nodiscard]] bool wait_until_taken(RawReaders& readers, Condition done) {
    const auto until = Clock::now() + kPatience;
    while (!done()) {
      if (Clock::now() > until) return false;
      static_cast<void>(mailbox_.wait(kOnceMore));
      for (RawSample& sample : readers.take()) taken_.push_back(std::move(sample));
    }
    return true;
  }
  Mailbox mailbox_;
  std::vector<RawSample> taken_;
};

TEST_F(RawBus, GivesTheBytesOfTheWriter) {
  RawReaders readers(there_, mailbox_, kRoom);
  Writer<msg::ArmCommand> writer(here_);
  ASSERT_TRUE(writer.wait_matched(1, kPatience));
  msg::ArmCommand command;
  command.arm("north");
  command.node("planner/north");
  command.sequence_number(41);
  command.q({0.25, -1.5});
  ASSERT_TRUE(writer.write(command));
  ASSERT_TRUE(wait_until_taken(readers, [&] { return !taken_.empty(); }));
  const RawSample& sample = taken_[0];
  GuardedType<msg::ArmCommand> type;
  const std::string bytes = type.bytes_of(command);
  EXPECT_EQ(std::string(sample.bytes.begin(), sample.bytes.end()), bytes);
  EXPECT_EQ(sample.topic, index_of<msg::ArmCommand>());
  EXPECT_EQ(sample.key, "north");
  EXPECT_EQ(sample.writer, writer.id());
  EXPECT_EQ(sample.number, 1U);
  EXPECT_EQ(sample.sequence_number, 41U);
  EXPECT_GT(sample.written_ns, 0);
  EXPECT_FALSE(sample.withdrawn);
}

TEST_F(RawBus, RefusesWhatBreaksARuleOfTheWire) {
  RawReaders readers(there_, mailbox_, kRoom);
  Writer<msg::ArmCommand> writer(here_);
  ASSERT_TRUE(writer.wait_matched(1, kPatience));
  ASSERT_TRUE(wait_until_taken(readers, [&] { return readers.matched() == 1; }));
  msg::ArmCommand command;
  command.arm("north");
  command.q({1e9});  // beyond every joint
  ASSERT_TRUE(writer.write(command));
  command.q({0.5});
  command.schema(1);
  ASSERT_TRUE(writer.write(command));
  command.schema(msg::ArmCommand().schema());
  ASSERT_TRUE(writer.write(command));
  ASSERT_TRUE(wait_until_taken(readers, [&] { return !taken_.empty(); }));
  EXPECT_EQ(taken_.size(), 1U);
  const RawCounters counters = readers.counters()[index_of<msg::ArmCommand>()];
  EXPECT_EQ(counters.received, 1U);
  EXPECT_EQ(counters.refused, 1U);
  EXPECT_EQ(counters.unreadable, 2U);
  const auto refused = there_.refused(kPatience, 10);
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_EQ(refused[0].topic, "ArmCommand");
}

TEST_F(RawBus, RefusesASecondWriterOfAKey) {
  RawReaders readers(there_, mailbox_, kRoom);
  Participant intruder(domain_.number(), "intruder", one_host());
  Writer<msg::ArmState> driver(here_);
  Writer<msg::ArmState> second(intruder);
  ASSERT_TRUE(driver.wait_matched(1, kPatience));
  ASSERT_TRUE(second.wait_matched(1, kPatience));
  std::uint64_t number = 0;
  const std::size_t topic = index_of<msg::ArmState>();
  ASSERT_TRUE(wait_until_taken(readers, [&] {
    // The first writer holds the key while both go on.
    const auto began = Clock::now();
    static_cast<void>(driver.write(state(++number)));
    if (!taken_.empty() && Clock::now() - began < kOnceMore) static_cast<void>(second.write(state(1000 + number)));
    return readers.counters()[topic].refused > 0;
  }));
  for (const RawSample& sample : taken_) EXPECT_EQ(sample.writer, driver.id());
}

TEST_F(RawBus, TellsWhichKeyWasWithdrawn) {
  RawReaders readers(there_, mailbox_, kRoom);
  Writer<msg::GoalStatus> writer(here_);
  ASSERT_TRUE(writer.wait_matched(1, kPatience));
  msg::GoalStatus status;
  status.arm("north");
  status.goal("g1");
  ASSERT_TRUE(writer.write(status));
  ASSERT_TRUE(wait_until_taken(readers, [&] { return !taken_.empty(); }));
  ASSERT_TRUE(writer.retire(status));
  ASSERT_TRUE(wait_until_taken(readers, [&] { return taken_.size() == 2; }));
  EXPECT_TRUE(taken_[1].withdrawn);
  EXPECT_EQ(taken_[1].key, "north/g1");
  EXPECT_TRUE(taken_[1].bytes.empty());
}

TEST_F(RawBus, CountsWhatDoesNotFitIntoTheQueue) {
  RawReaders readers(there_, mailbox_, 2000);
  Writer<msg::ArmCommand> writer(here_);
  ASSERT_TRUE(writer.wait_matched(1, kPatience));
  msg::ArmCommand command;
  command.arm("north");
  const auto counters = [&] { return readers.counters()[index_of<msg::ArmCommand>()]; };
  // A reader that gets no processor time receives only the newest command.
  for (const auto until = Clock::now() + kPatience; counters().overflowed == 0;) {
    ASSERT_LT(Clock::now(), until);
    ASSERT_TRUE(writer.write(command));
  }
  EXPECT_TRUE(wait_until_taken(readers, [&] {
    const RawCounters now = counters();
    return taken_.size() == now.received - now.overflowed;
  }));
}

TEST(RawLoss, IsReportedByTheMiddleware) {
  const test::FreeDomain domain;
  ParticipantOptions lossy = one_host();
  lossy.discard = one_in(10);
  Participant here(domain.number(), "here", lossy);
  Participant there(domain.number(), "there", one_host());
  Mailbox mailbox;
  RawReaders readers(there, mailbox, kRoom);
  Writer<msg::ArmState> writer(here);
  ASSERT_TRUE(writer.wait_matched(1, kPatience));
  std::uint64_t written = 0;
  std::uint64_t gaps = 0;
  std::uint64_t last = 0;
  const auto until = Clock::now() + kPatience;
  while (gaps < 20 && Clock::now() < until) {
    ASSERT_TRUE(writer.write(state(++written)));
    static_cast<void>(mailbox.wait(std::chrono::milliseconds(1)));
    for (const RawSample& sample : readers.take()) {
      if (last > 0) gaps += sample.number - last - 1;
      last = sample.number;
    }
  }
  ASSERT_GE(gaps, 20U);
  const std::uint64_t lost = readers.counters()[index_of<msg::ArmState>()].lost;
  EXPECT_GE(lost, gaps);
  EXPECT_LE(lost, written);
}

}  // namespace
}  // namespace hecaton::bus
