/// Files of a recording: split, kept, repeated state, a full disk, and their contents as tables.

#include "services/recorder/recording.hpp"

#include <filesystem>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "services/recorder/bag.hpp"
#include "services/recorder/message_schema.hpp"
#include "services/recorder/recorder_service.hpp"
#include "services/recorder/save_signal.hpp"
#include "tests/support/full_disk.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using namespace services::recorder;
using namespace std::chrono_literals;

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kBegan = 1'700'000'000 * kSecond;

std::size_t topic_index(std::string_view type) {
  for (std::size_t i = 0; i < bus::kTopics.size(); ++i) {
    if (bus::kTopics[i].type == type) return i;
  }
  throw std::invalid_argument(std::string(type));
}

/// A sample of a topic at a time after the beginning. The recording does not look into its bytes.
RecordedSample sample(std::string_view type, std::uint64_t at, std::uint64_t number, std::size_t size = 100) {
  RecordedSample recorded;
  recorded.sample.topic = topic_index(type);
  std::mt19937_64 random(number);
  for (std::size_t i = 0; i < size; ++i) recorded.sample.bytes.push_back(static_cast<std::uint8_t>(random()));
  recorded.sample.key = "arm1";
  recorded.sample.writer.bytes[0] = 7;
  recorded.sample.number = number;
  recorded.node = "driver/arm1";
  recorded.log_time = kBegan + at;
  return recorded;
}

std::vector<AttachedFile> cell_file() {
  return {{"cell.yaml", "application/yaml", "cell: small"}};
}

std::vector<std::string> files_in(const TemporaryFolder& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST(Recording, HasTopicsWritersLossesAndAttachments) {
  const TemporaryFolder folder;
  const std::string path = folder.path("run.mcap");
  Recording recording({.path = path}, cell_file(), kBegan);
  for (std::uint64_t i = 0; i < 100; ++i) recording.write(sample("ArmState", i * kSecond / 50, i + 1));
  RecordedSample other = sample("ArmState", kSecond, 1);
  other.sample.writer.bytes[0] = 8;
  other.node = "driver/arm2";
  recording.write(other);
  RecordedSample withdrawn = sample("Goal", kSecond, 3);
  withdrawn.sample.withdrawn = true;
  recording.write(withdrawn);
  recording.report(R"({"cell":"small","topics":{"hecaton/ArmState":{"received":101,"missing":2,"lost":3}}})",
                   kBegan + kSecond);
  recording.close();

  const BagInfo info = bag_info(path);
  EXPECT_TRUE(info.file.whole());
  EXPECT_EQ(info.cell, "small");
  ASSERT_TRUE(info.topics.contains("hecaton/ArmState"));
  const TopicFigures& states = info.topics.at("hecaton/ArmState");
  EXPECT_EQ(states.messages, 101U);
  EXPECT_EQ(states.bytes, 101U * 100);
  EXPECT_EQ(states.schema, "hecaton::msg::ArmState");
  EXPECT_EQ(states.nodes, (std::set<std::string>{"driver/arm1", "driver/arm2"}));
  EXPECT_DOUBLE_EQ(info.duration(), 99.0 / 50.0);
  EXPECT_EQ(info.topics.at("recorder/withdrawn").messages, 1U);
  ASSERT_EQ(info.attachments.size(), 1U);
  EXPECT_EQ(info.attachments[0].name, "cell.yaml");
  EXPECT_EQ(info.losses.at("hecaton/ArmState"), (TopicLosses{101, 2, 3, 0, 0}));
}

TEST(Recording, PutsSamplesOntoTheDiskEachSecond) {
  const TemporaryFolder folder;
  const std::string path = folder.path("run.mcap");
  Recording recording({.path = path}, {}, kBegan);
  recording.write(sample("ArmState", 0, 1));
  recording.keep_up(kBegan + kSecond / 2);
  EXPECT_EQ(read_mcap(path, {}).messages, 0U);
  recording.keep_up(kBegan + kSecond);
  EXPECT_EQ(read_mcap(path, {}).messages, 1U);
}

TEST(Recording, SplitsBySizeIntoFilesThatStandAlone) {
  const TemporaryFolder folder;
  Recording recording({.path = folder.path("run.mcap"), .split_bytes = 300'000}, cell_file(), kBegan);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    recording.write(sample("ArmState", i * kSecond / 100, i + 1, 1000));
    recording.keep_up(kBegan + i * kSecond / 100);
  }
  recording.close();
  std::uint64_t messages = 0;
  EXPECT_EQ(recording.files().size(), 4U);  // 1 MB of random bytes
  for (const std::string& file : recording.files()) {
    const BagInfo info = bag_info(file);
    EXPECT_TRUE(info.file.whole()) << file;
    EXPECT_EQ(info.attachments.size(), 1U) << file;
    messages += info.topics.at("hecaton/ArmState").messages;
    EXPECT_LT(info.file.bytes, 330'000U) << file;  // indexes and summary come on top
  }
  EXPECT_EQ(messages, 1000U);
  EXPECT_EQ(files_in(folder),
            (std::vector<std::string>{"run-0001.mcap", "run-0002.mcap", "run-0003.mcap", "run-0004.mcap"}));
}

TEST(Recording, BeginsEachFileWithTheKeptStateOfTheCell) {
  const TemporaryFolder folder;
  Recording recording({.path = folder.path("run.mcap"), .split_time = 10s}, {}, kBegan);
  recording.write(sample("ObstacleShapes", 0, 1));
  recording.write(sample("ArmState", 0, 1));
  RecordedSample removed = sample("ObstacleShapes", 0, 2);
  removed.sample.key = "crate";
  recording.write(removed);
  removed.sample.withdrawn = true;
  recording.write(removed);
  recording.keep_up(kBegan + 10 * kSecond);
  recording.close();
  ASSERT_EQ(recording.files().size(), 2U);
  std::vector<std::string> topics;
  McapVisitor visitor;
  visitor.message = [&](const McapMessage& message) {
    topics.push_back(message.channel->topic);
    EXPECT_EQ(message.channel->metadata.at("repeated"), "true");
    EXPECT_EQ(message.log_time, kBegan);
  };
  EXPECT_TRUE(read_mcap(recording.files()[1], visitor).whole());
  EXPECT_EQ(topics, std::vector<std::string>{"hecaton/ObstacleShapes"});
  EXPECT_TRUE(bag_info(recording.files()[1]).topics.empty());  // counted once
}

TEST(Recording, KeepsTheLastMinutesAndRemovesOnlyItsOwnFiles) {
  const TemporaryFolder folder;
  folder.write("run-0000.mcap", "of another recording");
  Recording recording({.path = folder.path("run.mcap"), .keep = 2min}, {}, kBegan);
  std::string replaced;
  for (std::uint64_t i = 0; i <= 605; ++i) {  // ten minutes
    recording.write(sample("ArmState", i * kSecond, i + 1));
    recording.keep_up(kBegan + i * kSecond);
    if (i == 300) {
      // A person moves a file away and another file takes its name.
      replaced = recording.files().front();
      std::filesystem::rename(replaced, folder.path("moved.mcap"));
      folder.write(std::filesystem::path(replaced).filename().string(), "a person's");
    }
  }
  recording.close();
  EXPECT_TRUE(std::filesystem::exists(folder.path("run-0000.mcap")));
  EXPECT_TRUE(std::filesystem::exists(folder.path("moved.mcap")));
  EXPECT_TRUE(std::filesystem::exists(replaced));
  // Files of 12 s: those of the last two minutes, and the one that holds the beginning of these.
  const std::vector<std::string> files = recording.files();
  EXPECT_GE(files.size(), 10U);
  EXPECT_LE(files.size(), 12U);
  EXPECT_EQ(files_in(folder).size(), files.size() + 3);
  EXPECT_LE(bag_info(files.front()).first, kBegan + 485 * kSecond);
  EXPECT_EQ(bag_info(files.back()).last, kBegan + 605 * kSecond);
}

TEST(Recording, EndsWithASentenceWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  const std::string path = folder.path("run.mcap");
  std::string sentence;
  std::uint64_t flushed = 0;
  {
    Recording recording({.path = path}, cell_file(), kBegan);
    const FullDisk full(200'000);
    try {
      for (std::uint64_t i = 0; i < 1000; ++i) {
        recording.write(sample("ArmState", i * kSecond, i + 1, 1000));
        recording.keep_up(kBegan + (i + 1) * kSecond);
        flushed = i + 1;
      }
    } catch (const RecordingError& error) {
      sentence = error.what();
    }
  }
  EXPECT_NE(sentence.find("the disk is full"), std::string::npos) << sentence;
  EXPECT_EQ(sentence.find(path), 0U) << sentence;
  const BagInfo info = bag_info(path);
  EXPECT_TRUE(info.file.cut);
  EXPECT_TRUE(info.file.damages.empty());
  EXPECT_GT(flushed, 100U);
  EXPECT_EQ(info.topics.at("hecaton/ArmState").messages, flushed);
}

// A service tries again and again.
TEST(Recording, LeavesNoFileThatAFullDiskHasNoRoomFor) {
  const TemporaryFolder folder;
  for (const rlim_t room : {0, 10, 50, 100}) {
    const FullDisk full(room);
    EXPECT_THROW(Recording({.path = folder.path("run.mcap")}, cell_file(), kBegan), RecordingError) << room;
    EXPECT_EQ(files_in(folder), std::vector<std::string>{}) << room;
  }
}

TEST(Recording, GivesManyWritersOneChannelOfTheirTopic) {
  const TemporaryFolder folder;
  const std::string path = folder.path("run.mcap");
  Recording recording({.path = path}, {}, kBegan);
  const std::uint64_t writers = Recording::kMostChannels + 1000;
  for (std::uint64_t i = 0; i < writers; ++i) {
    RecordedSample recorded = sample("Goal", i, 1, 4);
    recorded.sample.writer.bytes[1] = static_cast<std::uint8_t>(i >> 8U);
    recorded.sample.writer.bytes[2] = static_cast<std::uint8_t>(i);
    recording.write(recorded);
  }
  recording.close();
  std::set<const McapChannel*> channels;
  McapVisitor visitor;
  visitor.message = [&](const McapMessage& message) { channels.insert(message.channel.get()); };
  EXPECT_EQ(read_mcap(path, visitor).messages, writers);
  EXPECT_EQ(channels.size(), Recording::kMostChannels + 1);
}

TEST(MessageSchema, HasTheStructureOfEachTopic) {
  for (const bus::TopicInfo& topic : bus::kTopics) {
    const std::string_view text = message_schema(topic.type);
    EXPECT_NE(text.find("struct " + std::string(topic.type) + " {"), std::string_view::npos) << topic.type;
    EXPECT_NE(text.find("SCHEMA_VERSION ="), std::string_view::npos) << topic.type;
    EXPECT_EQ(text.find("#include"), std::string_view::npos) << topic.type;
  }
}

bus::RawSample numbered(std::string_view type, std::uint64_t sequence_number, std::uint8_t writer = 1) {
  bus::RawSample raw;
  raw.topic = topic_index(type);
  raw.sequence_number = sequence_number;
  raw.writer.bytes[0] = writer;
  return raw;
}

TEST(LossCounter, CountsTheGapsOfEachWriter) {
  LossCounter counter;
  for (const std::uint64_t number : {5, 6, 9}) counter.note(numbered("ArmState", number));  // 7 and 8 are missing
  for (const std::uint64_t number : {1, 2}) counter.note(numbered("ArmState", number, 2));
  for (const std::uint64_t number : {1, 9})
    counter.note(numbered("GoalStatus", number));  // reliable: replaced, not lost
  const auto losses = counter.losses(std::vector<bus::RawCounters>(bus::kTopics.size()));
  EXPECT_EQ(losses[topic_index("ArmState")].missing, 2U);
  EXPECT_EQ(losses[topic_index("GoalStatus")].missing, 0U);
}

TEST(HostClocks, TakeTheLeastDifferenceOfEachSecond) {
  HostClocks clocks;
  clocks.note("left", kBegan + 500, kBegan + 100, 7);
  clocks.note("left", kBegan + 900, kBegan + 800, 1);
  clocks.note("right", kBegan, kBegan + 60 * kSecond, 0);
  const auto taken = clocks.take();
  ASSERT_EQ(taken.size(), 2U);
  EXPECT_EQ(taken.at("left").samples, 2U);
  EXPECT_EQ(taken.at("left").log_minus_publish, 100);
  EXPECT_EQ(taken.at("left").log_minus_stamp, static_cast<std::int64_t>(kBegan + 493));
  EXPECT_EQ(taken.at("right").log_minus_publish, -60 * static_cast<std::int64_t>(kSecond));
  EXPECT_TRUE(clocks.take().empty());
  for (std::size_t i = 0; i < 2 * HostClocks::kMostHosts; ++i) clocks.note(std::to_string(i), 1, 1, 1);
  EXPECT_EQ(clocks.take().size(), HostClocks::kMostHosts);
}

TEST(Recording, TellsTheClockOfAHostAndItsSteps) {
  const TemporaryFolder folder;
  const std::string path = folder.path("run.mcap");
  Recording recording({.path = path}, {}, kBegan);
  // In each second [ms]: 0.2 behind; stepped back by a minute, and forth again.
  const std::vector<std::int64_t> offsets{200'000, 300'000, 60'000'200'000, 60'000'100'000, 250'000};
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    recording.compare_clocks(
        R"({"hosts":{"left":{"heartbeats":10,"log_minus_publish_ns":)" + std::to_string(offsets[i]) + "}}}",
        kBegan + i * kSecond);
  }
  for (const char* foreign : {"[]", "{}", R"({"hosts":[1]})", R"({"hosts":{"left":1,"right":{"heartbeats":1}}})",
                              R"({"hosts":{"left":{"heartbeats":-1,"log_minus_publish_ns":0}}})",
                              R"({"hosts":{"left":{"heartbeats":1,"log_minus_publish_ns":9223372036854775807}}})"}) {
    recording.compare_clocks(foreign, kBegan + 5 * kSecond);
  }
  recording.close();
  const BagInfo info = bag_info(path);
  ASSERT_EQ(info.clocks.size(), 1U);
  const ClockFigures& clock = info.clocks.at("left");
  EXPECT_EQ(clock.seconds, 5U);
  EXPECT_EQ(clock.samples, 50U);
  EXPECT_EQ(clock.last, 250'000);
  EXPECT_EQ(clock.least, 200'000);
  EXPECT_EQ(clock.most, 60'000'200'000);
  EXPECT_EQ(clock.steps, 2U);
  EXPECT_EQ(clock.largest_step, 59'999'900'000);
  EXPECT_EQ(clock.stepped_at, kBegan + 2 * kSecond);
}

TEST(SaveSignal, IsTakenOnce) {
  const SaveSignal save;
  EXPECT_FALSE(SaveSignal::take());
  ASSERT_EQ(raise(SIGUSR1), 0);
  EXPECT_TRUE(SaveSignal::take());
  EXPECT_FALSE(SaveSignal::take());
}

TEST(Recording, SavesWhatWasBeforeAndAfterAnEvent) {
  const TemporaryFolder folder;
  Recording recording({.path = folder.path("run.mcap"), .keep = 60s}, {}, kBegan);  // files of 6 s
  for (std::uint64_t i = 0; i <= 400; ++i) {
    recording.write(sample("ArmState", i * kSecond, i + 1));
    recording.keep_up(kBegan + i * kSecond);
    if (i == 150) recording.save(kBegan + 180 * kSecond);
  }
  recording.close();
  std::vector<bool> recorded(401);
  for (const std::string& file : recording.files()) {
    const BagInfo info = bag_info(file);
    for (std::uint64_t i = (info.first - kBegan) / kSecond; i <= (info.last - kBegan) / kSecond; ++i)
      recorded[i] = true;
  }
  for (std::size_t i = 0; i <= 400; ++i) {
    const bool gone = i < 80 || (i > 190 && i < 330);
    const bool kept = (i >= 90 && i <= 180) || i >= 340;
    EXPECT_FALSE(gone && recorded[i]) << i;
    EXPECT_FALSE(kept && !recorded[i]) << i;
  }
}

TEST(Recording, RemovesItsOldestFilesAboveALimit) {
  const TemporaryFolder folder;
  const std::string row = folder.path("cell-20261128T120000Z.mcap");
  const std::string of_former_row = folder.path("cell-20261127T120000Z-0001.mcap");
  {
    Recording former({.path = of_former_row}, {}, kBegan);
    former.write(sample("ArmState", 0, 1, 50'000));
    former.close();
  }
  // Names of others, and files of others under our names.
  std::filesystem::copy_file(of_former_row, folder.path("cell2-20261127T120000Z-0001.mcap"));
  std::filesystem::copy_file(of_former_row, folder.path("cell-20261127T120000Z-0001 (copy).mcap"));
  const std::string foreign = folder.write("cell-20261127T120000Z-0002.mcap", "a person's");
  ASSERT_EQ(former_files(row, "cell"), std::vector<std::string>{of_former_row});

  Recording recording(
      {.path = row, .split_bytes = 100'000, .keep = 60s, .most_bytes = 500'000, .former = former_files(row, "cell")},
      {}, kBegan);
  recording.save(kBegan + 3600 * kSecond);
  std::uint64_t most = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    recording.write(sample("ArmState", i * kSecond / 100, i + 1, 10'000));
    recording.keep_up(kBegan + i * kSecond);
    if (i == 30) {
      EXPECT_TRUE(std::filesystem::exists(of_former_row));
    }
    std::uint64_t bytes = 0;
    for (const std::string& file : recording.files()) bytes += std::filesystem::file_size(file);
    most = std::max(most, bytes);
  }
  recording.close();
  EXPECT_GT(most, 350'000U);
  EXPECT_LE(most, 520'000U);  // indexes and summaries come on top
  EXPECT_FALSE(std::filesystem::exists(of_former_row));
  EXPECT_TRUE(std::filesystem::exists(foreign));
  EXPECT_EQ(files_in(folder).size(), recording.files().size() + 3);
}

TEST(RowOfService, IsSplitAsTheCellFileSays) {
  config::Record record{.host = "", .folder = "f", .keep = 50s, .after_fault = 1s, .limit = 40'000'000};
  const RecordingOptions by_default = row_of(record, "f/row.mcap");
  EXPECT_EQ(by_default.path, "f/row.mcap");
  EXPECT_EQ(by_default.keep, 50s);
  EXPECT_EQ(by_default.most_bytes, 40'000'000U);
  EXPECT_EQ(by_default.split_bytes, 4'000'000U) << "the open file is never removed: it must not fill the limit";
  EXPECT_EQ(by_default.split_time, 0s) << "a tenth of `keep`";
  record.split_size = 150'000;
  record.split_time = 3s;
  const RecordingOptions stated = row_of(record, "f/row.mcap");
  EXPECT_EQ(stated.split_bytes, 150'000U);
  EXPECT_EQ(stated.split_time, 3s);

  // By time, and by size.
  const TemporaryFolder folder;
  Recording recording(row_of(record, folder.path("row.mcap")), {}, kBegan);
  for (std::uint64_t i = 0; i < 9; ++i) {
    recording.write(sample("ArmState", i * kSecond, i + 1, i < 6 ? 100 : 100'000));
    recording.keep_up(kBegan + i * kSecond);
  }
  recording.close();
  EXPECT_EQ(recording.files().size(), 4U) << "after 3 s, after 6 s, and after two large messages";
}

}  // namespace
}  // namespace hecaton::test
