// Serialisation with several threads, other schemas and malformed bytes.
#include <array>
#include <thread>

#include <idl/arm.h>

#include "services/bus/type_support.hpp"
#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::bus {
namespace {

using rtps::InstanceHandle_t;

msg::ArmState sample_state(const std::string& arm) {
  msg::ArmState state;
  state.arm(arm);
  return state;
}

// The generated code serialises all keys of a type into one buffer.
TEST(Wire, GivesRightKeyHandlesInTwoThreads) {
  GuardedType<msg::ArmState> type;
  const auto left = sample_state("left");
  const auto right = sample_state("right");
  InstanceHandle_t left_handle;
  InstanceHandle_t right_handle;
  ASSERT_TRUE(type.key_handle(left, left_handle));
  ASSERT_TRUE(type.key_handle(right, right_handle));
  ASSERT_NE(left_handle, right_handle);
  const auto wrong = [&](const msg::ArmState& state, const InstanceHandle_t& expected) {
    int count = 0;
    for (int i = 0; i < 200'000; ++i) {
      InstanceHandle_t handle;
      if (!type.key_handle(state, handle) || !(handle == expected)) ++count;
    }
    return count;
  };
  int wrong_left = 0;
  std::jthread other([&] { wrong_left = wrong(left, left_handle); });
  EXPECT_EQ(wrong(right, right_handle), 0);
  other.join();
  EXPECT_EQ(wrong_left, 0);
}

class WireBus : public BusTest {};

TEST_F(WireBus, KeepsKeysOfTwoWritingThreadsApart) {
  Writer<msg::ArmCommand> first(here_);
  Reader<msg::ArmCommand> reader(there_);
  expect_matched(first, reader);
  // One writer, two threads, five keys each.
  const auto write_all = [&](const std::string& prefix) {
    int refused = 0;
    for (int i = 0; i < 500; ++i) {
      msg::ArmCommand command;
      command.arm(prefix + std::to_string(i % 5));
      command.node(command.arm());
      command.sequence_number(static_cast<std::uint64_t>(i));
      if (!first.write(command)) ++refused;
    }
    return refused;
  };
  int refused_left = 0;
  std::jthread other([&] { refused_left = write_all("left"); });
  EXPECT_EQ(write_all("right"), 0);
  other.join();
  EXPECT_EQ(refused_left, 0);
  // Each key's last five writes were 495…499; a sample under a wrong handle would overwrite another key's.
  ASSERT_TRUE(wait_until(reader, [&] {
    const auto& all = reader.latest();
    if (all.size() != 10) return false;
    for (const auto& [key, sample] : all) {
      if (sample.value.sequence_number() < 495) return false;
    }
    return true;
  }));
  for (const auto& [key, sample] : reader.latest()) {
    EXPECT_EQ(sample.value.node(), key);
    EXPECT_EQ(sample.value.sequence_number() % 5, static_cast<std::uint64_t>(key.back() - '0'));
  }
}

// Threads create and destroy endpoints of one participant, in both directions at once.
TEST_F(WireBus, MatchesEndpointsOfSeveralThreads) {
  const auto churn = [](Participant& own, Participant& other) {
    for (int i = 0; i < 10; ++i) {
      const Writer<msg::ArmCommand> writer(own);
      const Reader<msg::ArmCommand> reader(other);
      EXPECT_TRUE(writer.wait_matched(1, kPatience));
      EXPECT_TRUE(reader.wait_matched(1, kPatience));
    }
  };
  std::jthread first([&] { churn(here_, there_); });
  std::jthread second([&] { churn(there_, here_); });
  churn(here_, there_);
}

TEST_F(WireBus, CountsAndDropsSamplesOfAnotherSchema) {
  Writer<msg::ArmCommand> writer(here_);
  Reader<msg::ArmCommand> reader(there_);
  expect_matched(writer, reader);
  msg::ArmCommand command;
  command.arm("arm1");
  command.schema(msg::SCHEMA_VERSION + 1);
  ASSERT_TRUE(writer.write(command));
  ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().unreadable == 1; }));
  EXPECT_TRUE(reader.latest().empty());
  command.schema(msg::SCHEMA_VERSION);
  ASSERT_TRUE(writer.write(command));
  EXPECT_TRUE(wait_until(reader, [&] { return reader.latest("arm1") != nullptr; }));
}

TEST(Wire, TurnsMalformedBytesIntoASampleOfSchemaZero) {
  GuardedType<msg::ArmState> type;
  const std::string whole = type.bytes_of(sample_state("arm1"));
  msg::ArmState read;
  type.read(whole, read);
  EXPECT_EQ(read.schema(), msg::SCHEMA_VERSION);
  EXPECT_EQ(read.arm(), "arm1");
  // A cut payload is never taken for a sample.
  for (std::size_t length = 0; length + 4 < whole.size(); ++length) {
    type.read(whole.substr(0, length), read);
    ASSERT_EQ(read.schema(), 0U) << length << " of " << whole.size();
  }
  // A string that claims 4 GB: the length of `arm` is the second word after the 4 bytes of encapsulation.
  type.read(whole.substr(0, 8) + "\xff\xff\xff\xff" + whole.substr(12), read);
  EXPECT_EQ(read.schema(), 0U);
}

}  // namespace
}  // namespace hecaton::bus
