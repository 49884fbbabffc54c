#include "services/recorder/mcap_reader.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include <zstd.h>

namespace hecaton::services::recorder {
namespace {

/// A record of the file. Bodies of indexes and unknown records are skipped.
struct Record {
  std::uint8_t opcode = 0;
  std::uint64_t at = 0;  ///< offset in the file
  Bytes body;
};

bool is(std::uint8_t opcode, Opcode wanted) {
  return opcode == static_cast<std::uint8_t>(wanted);
}

/// A file that cannot be opened, as a sentence.
RecordingError not_opened(const std::string& path, const std::string& reason) {
  return RecordingError(path + " cannot be read: " + reason + "; name a recording (.mcap)");
}

struct Unpacked {
  std::optional<Bytes> records;  ///< empty: the chunk cannot be read
  std::string damage;            ///< then why: a phrase that follows "the chunk"
};

/// Of the body of a chunk. Throws std::out_of_range when it is cut off.
Unpacked unpack(ByteSpan chunk) {
  ByteReader fields(chunk);
  static_cast<void>(fields.number<std::uint64_t>());
  static_cast<void>(fields.number<std::uint64_t>());
  const auto size = fields.number<std::uint64_t>();
  const auto crc = fields.number<std::uint32_t>();
  const std::string compression = fields.text();
  const ByteSpan packed = fields.bytes(fields.number<std::uint64_t>());
  if (compression != "zstd" && !compression.empty()) {
    return {std::nullopt, " is damaged, or its compression is not zstd"};
  }
  Bytes records;
  if (compression.empty()) {
    records.assign(packed.begin(), packed.end());
  } else if (size <= kLargestPart && ZSTD_getFrameContentSize(packed.data(), packed.size()) == size) {
    records.resize(static_cast<std::size_t>(size));
    const std::size_t got = ZSTD_decompress(records.data(), records.size(), packed.data(), packed.size());
    if (ZSTD_isError(got) != 0) records.clear();
  }
  if (records.size() != size || crc32_of(records) != crc || fields.left() > 0) return {std::nullopt, " is damaged"};
  return {std::move(records), {}};
}

/// The records of an unpacked chunk, one after the other. Throws std::out_of_range when one is cut off.
template <class Visit>
void for_each_record(ByteSpan records, const Visit& visit) {
  ByteReader reader(records);
  while (reader.left() > 0) {
    const auto opcode = reader.number<std::uint8_t>();
    visit(opcode, reader.bytes(reader.number<std::uint64_t>()));
  }
}

/// Its channel is not set. Returns the number of the channel.
std::uint16_t read_message(ByteSpan body, McapMessage& message) {
  ByteReader fields(body);
  const auto number = fields.number<std::uint16_t>();
  message.sequence = fields.number<std::uint32_t>();
  message.log_time = fields.number<std::uint64_t>();
  message.publish_time = fields.number<std::uint64_t>();
  message.data = fields.bytes(fields.left());
  return number;
}

class Reading {
 public:
  Reading(const std::string& path, const McapVisitor& visitor, std::uint64_t most_bytes)
      : path_(path), visitor_(visitor), file_(path, std::ios::binary) {
    std::error_code error;
    report_.bytes = std::min<std::uint64_t>(std::filesystem::file_size(path, error), most_bytes);
    if (!file_ || error) {
      throw not_opened(path, error ? error.message() : std::strerror(errno));
    }
  }

  McapReport run() {
    Bytes magic;
    if (!read(kMagic.size(), magic) || !std::equal(magic.begin(), magic.end(), kMagic.begin())) {
      throw RecordingError(path_ + " is no MCAP file; name a file that `hecaton record` has written");
    }
    take_descriptions_of_summary();
    while (std::optional<Record> record = next()) {
      if (is(record->opcode, Opcode::kFooter)) {
        end(*record);
        return std::move(report_);
      }
      take(*record);
      if (ended_by_visitor_) return std::move(report_);
    }
    report_.cut = true;
    return std::move(report_);
  }

 private:
  void damage(std::string phrase) {
    constexpr std::size_t kMost = 20;
    if (report_.damages.size() < kMost) report_.damages.push_back(std::move(phrase));
  }
  static std::string place(const char* what, std::uint64_t at) {
    return std::string("the ") + what + " at byte " + std::to_string(at);
  }

  /// False: the file ends before.
  bool read(std::uint64_t size, Bytes& bytes) {
    if (size > report_.bytes - at_) return false;
    bytes.resize(static_cast<std::size_t>(size));
    file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (static_cast<std::uint64_t>(file_.gcount()) != size) return false;
    at_ += size;
    crc_ = crc32_of(bytes, crc_);
    return true;
  }

  /// Schemas and channels stand in a chunk, and again in the summary of a whole file: so the loss of that chunk is no
  /// loss of later messages. Takes nothing from a file without a sound summary.
  void take_descriptions_of_summary() {
    constexpr std::uint64_t kFooter = kRecordHead + 20;
    const std::uint64_t begin = at_;
    try {
      if (report_.bytes < begin + kFooter + kMagic.size()) return;
      const std::uint64_t footer_at = report_.bytes - kMagic.size() - kFooter;
      const Bytes end = read_at(footer_at, kFooter + kMagic.size());
      ByteReader footer(ByteSpan(end).subspan(kRecordHead));
      const auto start = footer.number<std::uint64_t>();
      static_cast<void>(footer.number<std::uint64_t>());
      const auto crc = footer.number<std::uint32_t>();
      const bool has_footer =
          is(end.front(), Opcode::kFooter) && std::equal(kMagic.rbegin(), kMagic.rend(), end.rbegin());
      if (has_footer && start >= begin && start < footer_at && footer_at - start <= kLargestPart) {
        const Bytes summary = read_at(start, footer_at - start);
        if (crc32_of(ByteSpan(end).first(kFooter - 4), crc32_of(summary)) == crc) take_descriptions(summary);
      }
    } catch (const std::out_of_range&) {
      // What was read until then has the CRC of the summary.
    }
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(begin));
  }

  /// Throws std::out_of_range when the file has become shorter.
  Bytes read_at(std::uint64_t at, std::uint64_t size) {
    Bytes bytes(static_cast<std::size_t>(size));
    file_.seekg(static_cast<std::streamoff>(at));
    file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (static_cast<std::uint64_t>(file_.gcount()) != size) throw std::out_of_range("the file has become shorter");
    return bytes;
  }

  void take_descriptions(ByteSpan records) {
    for_each_record(records, [&](std::uint8_t opcode, ByteSpan body) {
      if (is(opcode, Opcode::kSchema)) take_schema(body);
      if (is(opcode, Opcode::kChannel)) take_channel(body);
    });
  }

  /// The next record; empty at the end of the file, and when the record is not whole.
  std::optional<Record> next() {
    Record record;
    record.at = at_;
    crc_before_ = crc_;
    Bytes head;
    if (!read(kRecordHead, head)) return std::nullopt;
    ByteReader fields(head);
    record.opcode = fields.number<std::uint8_t>();
    const auto size = fields.number<std::uint64_t>();
    if (size > report_.bytes - at_) return std::nullopt;
    if (size <= kLargestPart) return read(size, record.body) ? std::optional(std::move(record)) : std::nullopt;
    damage(place("record", record.at) + " is larger than 268 MB, the most that is read");
    return std::nullopt;
  }

  void take(const Record& record) {
    try {
      if (is(record.opcode, Opcode::kChunk)) {
        take_chunk(record);
      } else if (is(record.opcode, Opcode::kAttachment)) {
        take_attachment(record);
      } else if (is(record.opcode, Opcode::kMessage)) {
        damage(place("message", record.at) + " is in no chunk, so that no CRC proves it");
      } else if (is(record.opcode, Opcode::kDataEnd)) {
        data_ended_ = true;
        ByteReader fields(record.body);
        if (fields.number<std::uint32_t>() != crc_before_)
          damage("the data section has another CRC than it should have");
        summary_at_ = at_;
        crc_ = 0;  // from now on of the summary
      }
    } catch (const std::out_of_range&) {
      damage(place("record", record.at) + " is damaged");
    }
  }

  /// Throws std::out_of_range for a footer that is cut off.
  void end(const Record& footer) {
    Bytes magic;
    const bool complete = read(kMagic.size(), magic) && at_ == report_.bytes &&
                          std::equal(magic.begin(), magic.end(), kMagic.begin()) && footer.body.size() == 20;
    if (!complete || !data_ended_) {
      damage("the end of the file is damaged");
      return;
    }
    ByteReader fields(footer.body);
    const auto start = fields.number<std::uint64_t>();
    static_cast<void>(fields.number<std::uint64_t>());
    // crc_before_ is that of the summary's records before the footer.
    Bytes prefix;
    ByteWriter(prefix).number(footer.opcode).number(std::uint64_t{20}).bytes(ByteSpan(footer.body).first(16));
    const std::uint32_t crc = crc32_of(prefix, crc_before_);
    if (start != summary_at_ || fields.number<std::uint32_t>() != crc) damage("the summary is damaged");
  }

  void take_attachment(const Record& record) {
    ByteReader fields(record.body);
    static_cast<void>(fields.number<std::uint64_t>());
    static_cast<void>(fields.number<std::uint64_t>());
    McapAttachment attachment;
    attachment.name = fields.text();
    attachment.media_type = fields.text();
    attachment.data = fields.bytes(fields.number<std::uint64_t>());
    const std::uint32_t crc = crc32_of(ByteSpan(record.body).first(fields.at()));
    if (fields.number<std::uint32_t>() != crc || fields.left() > 0) {
      damage(place("attachment", record.at) + " is damaged");
    } else if (visitor_.attachment) {
      visitor_.attachment(attachment);
    }
  }

  void take_chunk(const Record& record) {
    const Unpacked chunk = unpack(record.body);
    if (!chunk.records) {
      damage(place("chunk", record.at) + chunk.damage);
      return;
    }
    if (visitor_.chunk && !visitor_.chunk(record.at)) {
      ended_by_visitor_ = true;
      return;
    }
    ++report_.chunks;
    take_descriptions(*chunk.records);
    for_each_record(*chunk.records, [&](std::uint8_t opcode, ByteSpan body) {
      if (is(opcode, Opcode::kMessage)) take_message(body, record.at);
    });
  }

  void take_schema(ByteSpan body) {
    ByteReader fields(body);
    const auto number = fields.number<std::uint16_t>();
    auto schema = std::make_shared<McapSchema>();
    schema->name = fields.text();
    schema->encoding = fields.text();
    schema->data = fields.text();
    schemas_.try_emplace(number, std::move(schema));
  }

  void take_channel(ByteSpan body) {
    ByteReader fields(body);
    const auto number = fields.number<std::uint16_t>();
    const auto schema = fields.number<std::uint16_t>();
    auto channel = std::make_shared<McapChannel>();
    channel->topic = fields.text();
    channel->encoding = fields.text();
    channel->metadata = fields.map();
    if (const auto known = schemas_.find(schema); known != schemas_.end()) {
      channel->schema = known->second;
    } else if (schema != 0) {
      damage("channel " + std::to_string(number) + " names a schema that a damaged chunk has");
      return;
    }
    report_.channels.try_emplace(number, std::move(channel));
  }

  void take_message(ByteSpan body, std::uint64_t chunk) {
    McapMessage message;
    const std::uint16_t number = read_message(body, message);
    const auto channel = report_.channels.find(number);
    if (channel == report_.channels.end()) {
      if (orphaned_.insert({number, chunk}).second) {
        damage("messages of channel " + std::to_string(number) +
               " cannot be read, because a damaged chunk describes it");
      }
      return;
    }
    message.channel = channel->second;
    ++report_.messages;
    if (visitor_.message) visitor_.message(message);
  }

  const std::string& path_;
  const McapVisitor& visitor_;
  std::ifstream file_;
  McapReport report_;
  std::uint64_t at_ = 0;
  std::uint32_t crc_ = 0;         ///< of all bytes so far; behind the data section: of the summary
  std::uint32_t crc_before_ = 0;  ///< before the current record
  bool data_ended_ = false;
  bool ended_by_visitor_ = false;
  std::uint64_t summary_at_ = 0;
  std::map<std::uint16_t, std::shared_ptr<const McapSchema>> schemas_;
  std::map<std::uint16_t, std::uint64_t> orphaned_;  ///< channels without description, with a chunk that uses each
};

}  // namespace

McapReport read_mcap(const std::string& path, const McapVisitor& visitor, std::uint64_t most_bytes) {
  return Reading(path, visitor, most_bytes).run();
}

McapChunks::McapChunks(std::string path, McapChannels channels)
    : path_(std::move(path)), channels_(std::move(channels)), file_(path_, std::ios::binary) {
  if (!file_) throw not_opened(path_, std::strerror(errno));
}

std::vector<McapMessage> McapChunks::messages(std::uint64_t at, Bytes& records) {
  const auto gone = [&] {
    return RecordingError(path_ + " has changed since it was opened: its chunk at byte " + std::to_string(at) +
                          " is not there any more; open it again");
  };
  const auto read = [&](std::uint64_t size) {
    Bytes bytes(static_cast<std::size_t>(size));
    file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (static_cast<std::uint64_t>(file_.gcount()) != size) throw gone();
    return bytes;
  };
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(at));
  const Bytes head = read(kRecordHead);
  ByteReader fields(head);
  const auto opcode = fields.number<std::uint8_t>();
  const auto size = fields.number<std::uint64_t>();
  if (!is(opcode, Opcode::kChunk) || size > kLargestPart) throw gone();
  std::vector<McapMessage> messages;
  try {
    Unpacked chunk = unpack(read(size));
    if (!chunk.records) throw gone();
    records = std::move(*chunk.records);
    for_each_record(records, [&](std::uint8_t kind, ByteSpan body) {
      if (!is(kind, Opcode::kMessage)) return;
      McapMessage message;
      const auto channel = channels_.find(read_message(body, message));
      if (channel == channels_.end()) return;
      message.channel = channel->second;
      messages.push_back(std::move(message));
    });
  } catch (const std::out_of_range&) {
    // read_mcap() has passed on what comes before the damage.
  }
  return messages;
}

}  // namespace hecaton::services::recorder
