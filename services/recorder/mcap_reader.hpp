#pragma once
/// Reads a recording in the format MCAP: from its beginning to its end, without its indexes, or one chunk of it. It
/// passes on only what a CRC has proven: a file that is cut or damaged gives fewer messages, never wrong ones.
///
/// It reads files whose schemas, channels and messages are in chunks with a CRC, as mcap_writer writes them. Other
/// files give a sentence in McapReport::damages.

#include <cstdint>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "services/recorder/mcap_format.hpp"

namespace hecaton::services::recorder {

struct McapSchema {
  std::string name;
  std::string encoding;
  std::string data;
};

struct McapChannel {
  std::string topic;
  std::string encoding;  ///< of messages
  StringMap metadata;
  std::shared_ptr<const McapSchema> schema;  ///< null: none
};

struct McapMessage {
  std::shared_ptr<const McapChannel> channel;  ///< never null
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;      ///< since 1970 [ns]
  std::uint64_t publish_time = 0;  ///< since 1970 [ns]
  ByteSpan data;                   ///< valid during the call
};

struct McapAttachment {
  std::string name;
  std::string media_type;
  ByteSpan data;  ///< valid during the call
};

/// Called in the order of the file. Empty functions are not called.
struct McapVisitor {
  std::function<void(const McapMessage&)> message{};
  std::function<void(const McapAttachment&)> attachment{};
  /// Called before the messages of the chunk that begins at this byte; false ends the reading.
  std::function<bool(std::uint64_t at)> chunk{};
};

using McapChannels = std::map<std::uint16_t, std::shared_ptr<const McapChannel>>;  ///< by their number in the file

struct McapReport {
  std::uint64_t bytes = 0;   ///< of the file
  std::uint64_t chunks = 0;  ///< read
  std::uint64_t messages = 0;
  bool cut = false;  ///< the file ends before its summary: its writer was killed, the disk was full, or it still writes
  /// What could not be read, a phrase each with its place: "the chunk at byte 4711 is damaged". Empty: nothing.
  std::vector<std::string> damages;
  McapChannels channels;  ///< described so far

  [[nodiscard]] bool whole() const { return !cut && damages.empty(); }
};

/// The largest chunk or attachment that is read [byte].
inline constexpr std::uint64_t kLargestPart = std::uint64_t{1} << 28U;

/// Reads at most the first `most_bytes` of a file, which may grow meanwhile. Throws RecordingError when the file cannot
/// be opened or is no MCAP file, and what the visitor throws.
McapReport read_mcap(const std::string& path, const McapVisitor& visitor,
                     std::uint64_t most_bytes = std::numeric_limits<std::uint64_t>::max());

/// Reads single chunks of a file in any order. For one thread.
class McapChunks {
 public:
  /// `channels`: as read_mcap() has reported them for this file. Throws RecordingError when the file cannot be opened.
  McapChunks(std::string path, McapChannels channels);

  /// The messages of the chunk at this byte, as read_mcap() has passed them on. They are valid as long as `records`
  /// is unchanged. Throws RecordingError when the chunk is not there any more.
  [[nodiscard]] std::vector<McapMessage> messages(std::uint64_t at, Bytes& records);

 private:
  std::string path_;
  McapChannels channels_;
  std::ifstream file_;
};

}  // namespace hecaton::services::recorder
