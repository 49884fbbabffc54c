// An intruder floods all processes of a cell with forged samples of every topic. No arm moves, no process ends, memory
// does not grow, and the cell runs again when the flood has ceased.
#include "tests/cell/intruder/flood.hpp"

#include <array>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/bus/raw_reader.hpp"
#include "services/bus/wire_rules.hpp"
#include "tests/cell/intruder/intruder.hpp"

namespace hecaton::test {
namespace {

constexpr std::size_t kRead = 15;  // topics with readers in this cell

/// Samples of each topic: those that the cell sends now, otherwise the seeds of the fuzz tests.
std::vector<std::vector<Bytes>> seeds(int domain) {
  constexpr std::size_t kMost = 40;
  std::vector<std::vector<Bytes>> samples(bus::kTopics.size());
  bus::ParticipantOptions options;
  options.partition = "three_puma";
  bus::Participant participant(domain, "recorder", options);
  bus::Mailbox mailbox;
  bus::RawReaders readers(participant, mailbox, 16U << 20U);
  for (const auto until = bus::Clock::now() + 3s; bus::Clock::now() < until;) {
    static_cast<void>(mailbox.wait(std::chrono::milliseconds(50)));
    static_cast<void>(mailbox.take_events());
    for (bus::RawSample& sample : readers.take()) {
      if (!sample.withdrawn && samples[sample.topic].size() < kMost) {
        samples[sample.topic].push_back(std::move(sample.bytes));
      }
    }
  }
  for (std::size_t topic = 0; topic < samples.size(); ++topic) {
    if (!samples[topic].empty()) continue;
    std::ifstream stream(std::string(HECATON_SOURCE_DIR) + "/tests/fuzz/corpus/samples/" +
                             std::string(bus::kTopics[topic].type) + "_full",
                         std::ios::binary);
    Bytes bytes{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_GT(bytes.size(), 1U) << bus::kTopics[topic].type;
    bytes.erase(bytes.begin());  // the topic's number
    samples[topic].push_back(std::move(bytes));
  }
  return samples;
}

#define HECATON_KEYED(Type, key, ...) std::string_view(#key) != "\"\"",
constexpr std::array kKeyed{HECATON_TOPICS(HECATON_KEYED)};
#undef HECATON_KEYED

/// In an open cell every program may write goals and orders as `hecaton` does: such samples are not forged.
bool is_for_everyone(const bus::TopicInfo& topic) {
  return topic.writers.find("cli") != std::string_view::npos;
}

TEST_F(Flood, OfForgedSamplesMovesNoArm) {
  const auto samples = seeds(domain_.number());
  RawParticipant intruder(domain_.number(), "");
  std::vector<std::unique_ptr<RawWriter>> writers;
  for (std::size_t topic = 0; topic < bus::kTopics.size(); ++topic) {
    const bus::TopicInfo& info = bus::kTopics[topic];
    writers.push_back(
        std::make_unique<RawWriter>(intruder, "*", std::string(info.type), info.qos, kKeyed[topic], true));
  }
  // The replies, the topics of devices and the ticks of planners have no readers here.
  std::string unread;
  ASSERT_TRUE(await([&] {
    unread.clear();
    std::size_t matched = 0;
    for (std::size_t topic = 0; topic < writers.size(); ++topic) {
      if (writers[topic]->matched())
        ++matched;
      else
        unread += std::string(bus::kTopics[topic].type) + " ";
    }
    return matched >= kRead;
  })) << unread;
  Mutator mutator(33);
  const std::size_t wanted = flood_size();
  for (std::size_t sent = 0; sent < wanted;) {
    const std::size_t topic = mutator.below(bus::kTopics.size());
    Bytes sample = samples[topic][mutator.below(samples[topic].size())];
    if (mutator.below(4) != 0) sample = mutator.mutated(std::move(sample));
    if (is_for_everyone(bus::kTopics[topic]) &&
        !bus::check_sample(*bus::topic_rule(bus::kTopics[topic].type), sample).refusal) {
      continue;
    }
    writers[topic]->write(std::string(sample.begin(), sample.end()));
    if (++sent % 256 == 0) watch();
  }
  watch();
  expect_unharmed(wanted, true);
  EXPECT_TRUE(named_.contains(msg::CauseKind::CAUSE_INPUT_REFUSED));
  EXPECT_TRUE(named_.contains(msg::CauseKind::CAUSE_SECOND_WRITER));
}

}  // namespace
}  // namespace hecaton::test
