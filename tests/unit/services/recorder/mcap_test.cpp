/// The file format: its bytes, and what a reader makes of files that are cut or damaged.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include "services/recorder/mcap_reader.hpp"
#include "services/recorder/mcap_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using namespace services::recorder;

Bytes content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void put_content(const std::string& path, ByteSpan bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::string hex(ByteSpan bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4U];
    text += "0123456789abcdef"[byte & 15U];
  }
  return text;
}

std::uint32_t zlib_crc(ByteSpan bytes) {
  return static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<unsigned>(bytes.size())));
}

/// A number as it stands in the file.
template <class T>
std::string le(T value) {
  Bytes bytes;
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  return hex(bytes);
}

TEST(McapWriter, WritesTheBytesOfTheSpecification) {
  const TemporaryFolder folder;
  const std::string path = folder.path("small.mcap");
  {
    McapWriter writer(path, "hecaton");
    EXPECT_EQ(writer.add_schema("S", "omgidl", "x"), 1);
    EXPECT_EQ(writer.add_channel(1, "t", "cdr", {{"k", "v"}}), 1);
    const Bytes data{0xAA, 0xBB};
    writer.write({1, 7, 1000, 999, data});
    writer.close();
  }
  const Bytes file = content(path);
  // Magic; header (01) of 15 bytes: profile "", library "hecaton".
  const std::string head =
      "894d434150300d0a"
      "01"
      "0f00000000000000"
      "00000000"
      "070000006865636174 6f6e";
  std::string expected_head = head;
  expected_head.erase(std::remove(expected_head.begin(), expected_head.end(), ' '), expected_head.end());
  ASSERT_EQ(hex(ByteSpan(file).first(32)), expected_head);

  // Schema (03) of 22 bytes, channel (04) of 30 bytes, message (05) of 24 bytes: 31 + 39 + 33 = 103 bytes.
  const std::string schema =
      "031600000000000000"
      "0100"
      "0100000053"
      "060000006f6d6769646c"
      "0100000078";
  const std::string channel =
      "041e00000000000000"
      "0100"
      "0100"
      "0100000074"
      "03000000636472"
      "0a000000"
      "010000006b"
      "0100000076";
  const std::string message =
      "051800000000000000"
      "0100"
      "07000000"
      "e803000000000000"
      "e703000000000000"
      "aabb";
  const std::string records = schema + channel + message;
  ASSERT_EQ(records.size(), 2U * 103);

  // Chunk (06) at byte 32: times 1000 and 1000, 103 bytes, their CRC, "zstd", the compressed size.
  const ByteSpan chunk = ByteSpan(file).subspan(32);
  ASSERT_EQ(chunk[0], 0x06);
  const std::uint64_t packed_size = chunk[9 + 36];
  const ByteSpan packed = chunk.subspan(9 + 44, packed_size);
  Bytes unpacked(103);
  ASSERT_EQ(ZSTD_decompress(unpacked.data(), unpacked.size(), packed.data(), packed.size()), 103U);
  EXPECT_EQ(hex(unpacked), records);
  const std::string fields = "06" + le(44 + packed_size) +
                             "e803000000000000"
                             "e803000000000000" +
                             le(std::uint64_t{103}) + le(zlib_crc(unpacked)) + "040000007a737464" + le(packed_size);
  EXPECT_EQ(hex(chunk.first(9 + 44)), fields);

  // Message index (07) of 22 bytes: channel 1, one entry: time 1000, offset 31 + 39 = 70.
  const std::uint64_t index_at = 32 + 9 + 44 + packed_size;
  const std::string index =
      "071600000000000000"
      "0100"
      "10000000"
      "e803000000000000"
      "4600000000000000";
  const std::uint64_t data_end_at = index_at + 31;
  const std::string data_end = "0f0400000000000000" + le(zlib_crc(ByteSpan(file).first(data_end_at)));
  EXPECT_EQ(hex(ByteSpan(file).subspan(index_at, 31 + 13)), index + data_end);

  // Summary: schema, channel, statistics (0b, 56 bytes), chunk index (08, 78 bytes), four offsets (0e, 17 bytes each).
  const std::uint64_t summary_at = data_end_at + 13;
  const std::string statistics = "0b3800000000000000" + le(std::uint64_t{1}) +
                                 "0100"
                                 "01000000"
                                 "00000000"
                                 "00000000"
                                 "01000000"
                                 "e803000000000000"
                                 "e803000000000000"
                                 "0a000000"
                                 "0100"
                                 "0100000000000000";
  const std::string chunk_index =
      "084e00000000000000"
      "e803000000000000"
      "e803000000000000"
      "2000000000000000" +
      le(index_at - 32) +
      "0a000000"
      "0100" +
      le(index_at) + le(std::uint64_t{31}) + "040000007a737464" + le(packed_size) + le(std::uint64_t{103});
  const auto offset = [](const char* opcode, std::uint64_t at, std::uint64_t size) {
    return "0e1100000000000000" + std::string(opcode) + le(at) + le(size);
  };
  const std::uint64_t offsets_at = summary_at + 31 + 39 + 65 + 87;
  const std::string offsets = offset("03", summary_at, 31) + offset("04", summary_at + 31, 39) +
                              offset("0b", summary_at + 70, 65) + offset("08", summary_at + 135, 87);
  const std::string footer = "021400000000000000" + le(summary_at) + le(offsets_at);
  const std::string summary = schema + channel + statistics + chunk_index + offsets + footer;
  ASSERT_EQ(file.size(), summary_at + summary.size() / 2 + 4 + 8);
  EXPECT_EQ(hex(ByteSpan(file).subspan(summary_at, summary.size() / 2)), summary);
  EXPECT_EQ(hex(ByteSpan(file).last(12)),
            le(zlib_crc(ByteSpan(file).subspan(summary_at, summary.size() / 2))) + "894d434150300d0a");
}

// It may hold what a cell with keys encrypts.
TEST(McapWriter, WritesForItsUserOnly) {
  const TemporaryFolder folder;
  const McapWriter writer(folder.path("private.mcap"), "hecaton");
  EXPECT_EQ(std::filesystem::status(folder.path("private.mcap")).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST(McapWriter, RefusesAnExistingFile) {
  const TemporaryFolder folder;
  const std::string path = folder.write("there.mcap", "precious");
  try {
    const McapWriter writer(path, "hecaton");
    FAIL() << "it was overwritten";
  } catch (const RecordingError& error) {
    EXPECT_NE(std::string(error.what()).find("exists already"), std::string::npos) << error.what();
  }
  EXPECT_EQ(content(path).size(), 8U);
}

/// Message `number` of the file below: its bytes follow from its number.
Bytes payload(std::uint64_t number) {
  std::mt19937_64 random(number);
  Bytes bytes(20 + number % 50);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

constexpr std::uint64_t kMessages = 400;
constexpr std::uint64_t kOfAChunk = 50;

/// Two channels with messages in turns, eight chunks and an attachment.
void write_sample_file(const std::string& path, bool closed = true) {
  McapWriter writer(path, "hecaton");
  writer.attach("cell.yaml", "application/yaml", 5, "cell: small");
  const std::uint16_t schema = writer.add_schema("S", "omgidl", "struct S {};");
  for (const char* topic : {"even", "odd"}) writer.add_channel(schema, topic, "cdr", {{"node", "n"}});
  for (std::uint64_t i = 0; i < kMessages; ++i) {
    const Bytes data = payload(i);
    writer.write({static_cast<std::uint16_t>(1 + i % 2), static_cast<std::uint32_t>(i), 1000 + i, 900 + i, data});
    if (i % kOfAChunk == kOfAChunk - 1) writer.flush();
  }
  if (closed) writer.close();
}

/// Reads the file and checks each value that it gives.
McapReport read_checked(const std::string& path) {
  McapVisitor visitor;
  visitor.message = [](const McapMessage& message) {
    const std::uint64_t number = message.sequence;
    ASSERT_LT(number, kMessages);
    EXPECT_EQ(message.log_time, 1000 + number);
    EXPECT_EQ(message.publish_time, 900 + number);
    EXPECT_EQ(message.channel->topic, number % 2 == 0 ? "even" : "odd");
    EXPECT_EQ(message.channel->metadata.at("node"), "n");
    ASSERT_NE(message.channel->schema, nullptr);
    EXPECT_EQ(message.channel->schema->name, "S");
    EXPECT_EQ(hex(message.data), hex(payload(number)));
  };
  visitor.attachment = [](const McapAttachment& attachment) {
    EXPECT_EQ(attachment.name, "cell.yaml");
    EXPECT_EQ(std::string(attachment.data.begin(), attachment.data.end()), "cell: small");
  };
  return read_mcap(path, visitor);
}

TEST(McapReader, ReadsWhatWasWritten) {
  const TemporaryFolder folder;
  write_sample_file(folder.path("a.mcap"));
  const McapReport report = read_checked(folder.path("a.mcap"));
  EXPECT_TRUE(report.whole());
  EXPECT_EQ(report.messages, kMessages);
  EXPECT_EQ(report.chunks, kMessages / kOfAChunk);
}

TEST(McapReader, ReadsUpToTheLastChunkOfAKilledWriter) {
  const TemporaryFolder folder;
  write_sample_file(folder.path("a.mcap"), false);
  const McapReport report = read_checked(folder.path("a.mcap"));
  EXPECT_TRUE(report.cut);
  EXPECT_TRUE(report.damages.empty());
  EXPECT_EQ(report.messages, kMessages);
}

TEST(McapReader, ReadsTheWholeChunksOfAFileCutAnywhere) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.mcap");
  write_sample_file(path);
  const Bytes whole = content(path);
  std::vector<std::uint64_t> chunk_ends;
  for (std::uint64_t at = 8; whole[at] != static_cast<std::uint8_t>(Opcode::kDataEnd);) {
    ByteReader head(ByteSpan(whole).subspan(at, kRecordHead));
    const auto opcode = head.number<std::uint8_t>();
    at += kRecordHead + head.number<std::uint64_t>();
    if (opcode == static_cast<std::uint8_t>(Opcode::kChunk)) chunk_ends.push_back(at);
  }
  std::mt19937 random(20);
  for (int i = 0; i < 1000; ++i) {
    const std::size_t size = std::uniform_int_distribution<std::size_t>(8, whole.size() - 1)(random);
    put_content(folder.path("cut.mcap"), ByteSpan(whole).first(size));
    const McapReport report = read_checked(folder.path("cut.mcap"));
    EXPECT_FALSE(report.whole()) << size;
    const auto chunks = std::count_if(chunk_ends.begin(), chunk_ends.end(), [&](auto end) { return end <= size; });
    EXPECT_EQ(report.messages, kOfAChunk * static_cast<std::uint64_t>(chunks)) << size;
  }
}

TEST(McapReader, FindsEachFlippedBitAndGivesNoWrongValue) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.mcap");
  write_sample_file(path);
  const Bytes whole = content(path);
  std::mt19937 random(21);
  std::uint64_t read = 0;
  for (int i = 0; i < 1000; ++i) {
    Bytes damaged = whole;
    const std::size_t bit = std::uniform_int_distribution<std::size_t>(0, 8 * whole.size() - 1)(random);
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    put_content(folder.path("damaged.mcap"), damaged);
    if (bit < 64) {
      EXPECT_THROW(read_checked(folder.path("damaged.mcap")), RecordingError) << bit;
      continue;
    }
    const McapReport report = read_checked(folder.path("damaged.mcap"));
    EXPECT_FALSE(report.whole()) << "bit " << bit;
    read += report.messages;
  }
  EXPECT_GT(read, 1000 * kMessages / 2);  // one chunk is lost, not the file
}

TEST(McapReader, LosesOnlyTheMessagesOfADamagedFirstChunk) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.mcap");
  write_sample_file(path);
  Bytes damaged = content(path);
  std::uint64_t at = kMagic.size();
  while (damaged[at] != static_cast<std::uint8_t>(Opcode::kChunk)) {
    at += kRecordHead + ByteReader(ByteSpan(damaged).subspan(at + 1, 8)).number<std::uint64_t>();
  }
  damaged[at + kRecordHead + 60] ^= 1U;
  put_content(folder.path("damaged.mcap"), damaged);
  const McapReport report = read_checked(folder.path("damaged.mcap"));
  EXPECT_EQ(report.messages, kMessages - kOfAChunk);
  EXPECT_FALSE(report.whole());
}

TEST(McapReader, SurvivesRandomBytesBehindTheMagic) {
  const TemporaryFolder folder;
  std::mt19937 random(22);
  for (int i = 0; i < 1000; ++i) {
    Bytes bytes(kMagic.begin(), kMagic.end());
    for (int k = 0; k < 100; ++k) bytes.push_back(static_cast<std::uint8_t>(k % 9 == 0 ? random() % 16 : random() % 3));
    put_content(folder.path("random.mcap"), bytes);
    const McapReport report = read_mcap(folder.path("random.mcap"), {});
    EXPECT_FALSE(report.whole());
    EXPECT_EQ(report.messages, 0U);
  }
}

TEST(McapReader, RefusesOtherFiles) {
  const TemporaryFolder folder;
  for (const std::string& path : {folder.write("text.mcap", "no recording at all"), folder.write("empty.mcap", ""),
                                  folder.path("missing.mcap"), folder.path().string()}) {
    try {
      static_cast<void>(read_mcap(path, {}));
      FAIL() << path;
    } catch (const RecordingError& error) {
      EXPECT_EQ(std::string(error.what()).find(path), 0U) << error.what();
    }
  }
}

}  // namespace
}  // namespace hecaton::test
