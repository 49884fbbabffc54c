#include "services/recorder/mcap_writer.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

namespace hecaton::services::recorder {
namespace {

/// Compresses states of a cell to a quarter at 400 MB/s; higher levels cost more than they save.
constexpr int kLevel = 1;

/// Appends a record to `to`.
void put_record(Bytes& to, Opcode opcode, ByteSpan body) {
  ByteWriter(to).number(static_cast<std::uint8_t>(opcode)).number(static_cast<std::uint64_t>(body.size())).bytes(body);
}

std::uint16_t next_number(const std::vector<Bytes>& records, const std::string& path, const char* kind) {
  if (records.size() >= std::numeric_limits<std::uint16_t>::max()) {
    throw RecordingError(path + " has 65535 " + kind + ", the most that the format allows; begin another recording");
  }
  return static_cast<std::uint16_t>(records.size() + 1);
}

FileIdentity identity_of(const struct stat& status) {
  return {static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino)};
}

}  // namespace

FileIdentity identity_of(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? identity_of(status) : FileIdentity{};
}

FileIdentity RecordFile::identity() const {
  struct stat status {};
  return ::fstat(fd_, &status) == 0 ? identity_of(status) : FileIdentity{};
}

RecordFile::RecordFile(std::string path) : path_(std::move(path)) {
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd_ >= 0) return;
  if (errno == EEXIST) throw RecordingError(path_ + " exists already; remove it or name another file");
  throw RecordingError(path_ + " cannot be created: " + std::strerror(errno) + "; name a file that can be written");
}

RecordFile::~RecordFile() {
  if (fd_ >= 0) ::close(fd_);
}

void RecordFile::append(ByteSpan bytes) {
  for (ByteSpan rest = bytes; !rest.empty();) {
    const ssize_t written = ::write(fd_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written > 0) {
      rest = rest.subspan(static_cast<std::size_t>(written));
      continue;
    }
    const int reason = written < 0 ? errno : ENOSPC;
    // The file ends with a whole record again. A disk without room for more can cut a file.
    static_cast<void>(::ftruncate(fd_, static_cast<off_t>(size_)));
    const bool full = reason == ENOSPC || reason == EFBIG || reason == EDQUOT;
    throw RecordingError(
        path_ + ": the recording has ended after " + std::to_string(size_ / 1000) + " kB, because " +
        (full ? "the disk is full" : std::string("the file cannot be written (") + std::strerror(reason) + ")") +
        "; what was recorded until then can be read; make room or name another file");
  }
  crc_ = crc32_of(bytes, crc_);
  size_ += bytes.size();
}

void RecordFile::sync() {
  // EINVAL: a file of another kind, such as /dev/stdout.
  if (::fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS) {
    throw RecordingError(path_ + ": the recording has ended, because the disk does not take it (" +
                         std::strerror(errno) + "); what was recorded until then can be read");
  }
}

void RecordFile::discard() {
  if (identity_of(path_) == identity()) static_cast<void>(::unlink(path_.c_str()));
}

McapWriter::McapWriter(const std::string& path, const std::string& library, const std::string& profile) : file_(path) {
  Bytes begin(kMagic.begin(), kMagic.end());
  Bytes header;
  ByteWriter(header).text(profile).text(library);
  put_record(begin, Opcode::kHeader, header);
  try {
    file_.append(begin);
  } catch (const RecordingError&) {
    file_.discard();
    throw;
  }
}

std::uint64_t McapWriter::append(Opcode opcode, const Bytes& body) {
  const std::uint64_t offset = file_.size();
  Bytes record;
  record.reserve(kRecordHead + body.size());
  put_record(record, opcode, body);
  file_.append(record);
  return offset;
}

std::uint16_t McapWriter::add_schema(const std::string& name, const std::string& encoding, std::string_view data) {
  const std::uint16_t number = next_number(schemas_, file_.path(), "schemas");
  Bytes body;
  ByteWriter(body).number(number).text(name).text(encoding).text(data);
  put_record(chunk_, Opcode::kSchema, body);
  schemas_.push_back(std::move(body));
  return number;
}

std::uint16_t McapWriter::add_channel(std::uint16_t schema, const std::string& topic, const std::string& encoding,
                                      const StringMap& metadata) {
  const std::uint16_t number = next_number(channels_, file_.path(), "channels");
  Bytes body;
  ByteWriter(body).number(number).number(schema).text(topic).text(encoding).map(metadata);
  put_record(chunk_, Opcode::kChannel, body);
  channels_.push_back(std::move(body));
  return number;
}

void McapWriter::write(const OutgoingMessage& message) {
  const std::uint64_t offset = chunk_.size();
  constexpr std::size_t kFields = 22;
  ByteWriter(chunk_)
      .number(static_cast<std::uint8_t>(Opcode::kMessage))
      .number(static_cast<std::uint64_t>(kFields + message.data.size()))
      .number(message.channel)
      .number(message.sequence)
      .number(message.log_time)
      .number(message.publish_time)
      .bytes(message.data);
  const bool first_of_chunk = indexes_.empty();
  chunk_first_ = first_of_chunk ? message.log_time : std::min(chunk_first_, message.log_time);
  chunk_last_ = first_of_chunk ? message.log_time : std::max(chunk_last_, message.log_time);
  indexes_[message.channel].emplace_back(message.log_time, offset);
  const bool first = statistics_.messages++ == 0;
  statistics_.first = first ? message.log_time : std::min(statistics_.first, message.log_time);
  statistics_.last = first ? message.log_time : std::max(statistics_.last, message.log_time);
  ++statistics_.by_channel[message.channel];
  if (chunk_.size() >= kChunk) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  Bytes packed(ZSTD_compressBound(chunk_.size()));
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), kLevel);
  if (ZSTD_isError(size) != 0)
    throw RecordingError(file_.path() + ": zstd cannot compress: " + ZSTD_getErrorName(size));
  packed.resize(size);
  if (indexes_.empty()) chunk_first_ = chunk_last_ = 0;  // schemas and channels only

  Bytes body;
  ByteWriter(body)
      .number(chunk_first_)
      .number(chunk_last_)
      .number(static_cast<std::uint64_t>(chunk_.size()))
      .number(crc32_of(chunk_))
      .text("zstd")
      .number(static_cast<std::uint64_t>(packed.size()))
      .bytes(packed);
  const std::uint64_t begin = append(Opcode::kChunk, body);
  const std::uint64_t end = file_.size();

  std::map<std::uint16_t, std::uint64_t> offsets;
  Bytes indexes;
  for (const auto& [channel, entries] : indexes_) {
    offsets[channel] = end + indexes.size();
    Bytes index;
    ByteWriter to(index);
    to.number(channel).number(static_cast<std::uint32_t>(entries.size() * 16));
    for (const auto& [time, offset] : entries) to.number(time).number(offset);
    put_record(indexes, Opcode::kMessageIndex, index);
  }
  file_.append(indexes);

  Bytes entry;
  ByteWriter(entry)
      .number(chunk_first_)
      .number(chunk_last_)
      .number(begin)
      .number(end - begin)
      .map(offsets)
      .number(static_cast<std::uint64_t>(indexes.size()))
      .text("zstd")
      .number(static_cast<std::uint64_t>(packed.size()))
      .number(static_cast<std::uint64_t>(chunk_.size()));
  chunk_indexes_.push_back(std::move(entry));
  chunk_.clear();
  indexes_.clear();
}

void McapWriter::attach(const std::string& name, const std::string& media_type, std::uint64_t time,
                        std::string_view data) {
  end_chunk();
  Bytes body;
  ByteWriter(body)
      .number(time)
      .number(time)
      .text(name)
      .text(media_type)
      .number(static_cast<std::uint64_t>(data.size()))
      .bytes({reinterpret_cast<const std::uint8_t*>(data.data()), data.size()});
  const std::uint32_t crc = crc32_of(body);
  ByteWriter(body).number(crc);
  const std::uint64_t offset = append(Opcode::kAttachment, body);
  Bytes entry;
  ByteWriter(entry)
      .number(offset)
      .number(file_.size() - offset)
      .number(time)
      .number(time)
      .number(static_cast<std::uint64_t>(data.size()))
      .text(name)
      .text(media_type);
  attachment_indexes_.push_back(std::move(entry));
}

void McapWriter::add_metadata(const std::string& name, const StringMap& values) {
  end_chunk();
  Bytes body;
  ByteWriter(body).text(name).map(values);
  const std::uint64_t offset = append(Opcode::kMetadata, body);
  Bytes entry;
  ByteWriter(entry).number(offset).number(file_.size() - offset).text(name);
  metadata_indexes_.push_back(std::move(entry));
}

void McapWriter::flush() {
  end_chunk();
  file_.sync();
}

Bytes McapWriter::statistics_body() const {
  Bytes body;
  ByteWriter(body)
      .number(statistics_.messages)
      .number(static_cast<std::uint16_t>(schemas_.size()))
      .number(static_cast<std::uint32_t>(channels_.size()))
      .number(static_cast<std::uint32_t>(attachment_indexes_.size()))
      .number(static_cast<std::uint32_t>(metadata_indexes_.size()))
      .number(static_cast<std::uint32_t>(chunk_indexes_.size()))
      .number(statistics_.first)
      .number(statistics_.last)
      .map(statistics_.by_channel);
  return body;
}

void McapWriter::close() {
  end_chunk();
  Bytes data_end;
  ByteWriter(data_end).number(file_.crc());
  append(Opcode::kDataEnd, data_end);

  const std::uint64_t start = file_.size();
  Bytes summary;
  Bytes offsets;
  const auto add_group = [&](Opcode opcode, const std::vector<Bytes>& records) {
    const std::uint64_t begin = start + summary.size();
    for (const Bytes& body : records) put_record(summary, opcode, body);
    if (records.empty()) return;
    Bytes offset;
    ByteWriter(offset).number(static_cast<std::uint8_t>(opcode)).number(begin).number(start + summary.size() - begin);
    put_record(offsets, Opcode::kSummaryOffset, offset);
  };
  add_group(Opcode::kSchema, schemas_);
  add_group(Opcode::kChannel, channels_);
  add_group(Opcode::kStatistics, {statistics_body()});
  add_group(Opcode::kChunkIndex, chunk_indexes_);
  add_group(Opcode::kAttachmentIndex, attachment_indexes_);
  add_group(Opcode::kMetadataIndex, metadata_indexes_);
  const std::uint64_t offset_start = start + summary.size();
  ByteWriter(summary)
      .bytes(offsets)
      .number(static_cast<std::uint8_t>(Opcode::kFooter))
      .number(std::uint64_t{20})
      .number(start)
      .number(offset_start);
  const std::uint32_t crc = crc32_of(summary);
  ByteWriter(summary).number(crc).bytes(kMagic);
  file_.append(summary);
  file_.sync();
}

}  // namespace hecaton::services::recorder
