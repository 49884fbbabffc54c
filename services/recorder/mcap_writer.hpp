#pragma once
/// Writes a file in the format MCAP: messages in chunks that zstd compresses, with a CRC for each chunk, and an index
/// and a summary at the end. Each record goes to the file whole: a file whose writer was killed reads up to the last
/// record.

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/recorder/mcap_format.hpp"

namespace hecaton::services::recorder {

/// Tells a file from another one that has its name later.
struct FileIdentity {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  bool operator==(const FileIdentity&) const = default;
};
/// Of the file at `path`; all 0: there is none.
[[nodiscard]] FileIdentity identity_of(const std::string& path);

/// A file to which records are appended. A record that does not fit onto the disk is taken back.
class RecordFile {
 public:
  /// Creates the file. Throws RecordingError, also when it exists already.
  explicit RecordFile(std::string path);
  ~RecordFile();
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  /// Throws RecordingError when the bytes cannot be written.
  void append(ByteSpan bytes);
  /// Waits until the disk has everything. Throws RecordingError.
  void sync();
  /// Removes the file, unless another one has its name by now.
  void discard();

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] std::uint32_t crc() const { return crc_; }  ///< of all bytes
  [[nodiscard]] FileIdentity identity() const;

 private:
  std::string path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
  std::uint32_t crc_ = 0;
};

/// A message on its way into the file.
struct OutgoingMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;      ///< of its writer; 0: none
  std::uint64_t log_time = 0;      ///< since 1970 [ns]
  std::uint64_t publish_time = 0;  ///< since 1970 [ns]
  ByteSpan data;
};

/// For one thread. Every function throws RecordingError when the file cannot be written; then only the destructor may
/// follow. The destructor of a file that was not closed leaves it without its summary, and without the open chunk.
class McapWriter {
 public:
  static constexpr std::size_t kChunk = 1U << 20U;  ///< a chunk ends above this size [byte]

  /// Creates the file. `profile`: a registered one that the file follows; empty: none. Throws RecordingError when the
  /// file exists already, or cannot be written; then no file remains of it.
  explicit McapWriter(const std::string& path, const std::string& library, const std::string& profile = {});

  /// The numbers that add_schema() and add_channel() return count from 1. Throw RecordingError after 65,535 of them.
  std::uint16_t add_schema(const std::string& name, const std::string& encoding, std::string_view data);
  /// `schema` 0: none.
  std::uint16_t add_channel(std::uint16_t schema, const std::string& topic, const std::string& encoding,
                            const StringMap& metadata);
  void write(const OutgoingMessage& message);
  /// A file of its own inside this one. `time`: since 1970 [ns].
  void attach(const std::string& name, const std::string& media_type, std::uint64_t time, std::string_view data);
  void add_metadata(const std::string& name, const StringMap& values);
  /// Writes the open chunk and waits until the disk has it.
  void flush();
  /// Writes the open chunk and the summary. Nothing may follow.
  void close();
  /// Removes the file, unless another one has its name by now. Nothing may follow.
  void discard() { file_.discard(); }

  [[nodiscard]] std::uint64_t size() const { return file_.size() + chunk_.size(); }  ///< at most, after flush() [byte]
  [[nodiscard]] std::uint64_t messages() const { return statistics_.messages; }
  [[nodiscard]] std::size_t channels() const { return channels_.size(); }
  [[nodiscard]] const std::string& path() const { return file_.path(); }
  [[nodiscard]] FileIdentity identity() const { return file_.identity(); }

 private:
  struct Statistics {
    std::uint64_t messages = 0;
    std::uint64_t first = 0;  ///< log time
    std::uint64_t last = 0;   ///< log time
    std::map<std::uint16_t, std::uint64_t> by_channel;
  };
  /// Log time and offset of each message of the open chunk.
  using MessageIndexes = std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>>;

  /// Ends the open chunk before a record that must not be in a chunk.
  void end_chunk();
  /// Returns the offset of the record.
  std::uint64_t append(Opcode opcode, const Bytes& body);
  [[nodiscard]] Bytes statistics_body() const;

  RecordFile file_;
  std::vector<Bytes> schemas_;   ///< bodies of records, for the summary
  std::vector<Bytes> channels_;  ///< the same
  Bytes chunk_;                  ///< records of the open chunk
  std::uint64_t chunk_first_ = 0;
  std::uint64_t chunk_last_ = 0;
  MessageIndexes indexes_;
  std::vector<Bytes> chunk_indexes_;
  std::vector<Bytes> attachment_indexes_;
  std::vector<Bytes> metadata_indexes_;
  Statistics statistics_;
};

}  // namespace hecaton::services::recorder
