#pragma once
/// A recording of a cell on the disk: one file or a row of files, with a channel for each topic and writer. It knows
/// samples and no network.

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "services/bus/raw_reader.hpp"
#include "services/recorder/mcap_writer.hpp"

namespace hecaton::services::recorder {

struct RecordingOptions {
  std::string path;                       ///< "run.mcap"; the files of a row are "run-0001.mcap" and so on
  std::uint64_t split_bytes = 0;          ///< begin another file above this size without attachments; 0: never
  std::chrono::nanoseconds split_time{};  ///< begin another file after this time; 0: never
  /// Remove files of the row that ended longer ago; 0: none. Without `split_time` a file then has a tenth of it.
  std::chrono::nanoseconds keep{};
  /// Remove the oldest files when all of the row are larger together, saved ones too [byte]; 0: no limit.
  std::uint64_t most_bytes = 0;
  bool ros2 = false;  ///< with the topics of hecaton-ros2
  /// Files of former rows, the oldest first. They count as saved.
  std::vector<std::string> former = {};

  [[nodiscard]] bool is_row() const { return split_bytes > 0 || split_time.count() > 0 || keep.count() > 0; }
};

/// A file that belongs to the recording.
struct AttachedFile {
  std::string name;
  std::string media_type;
  std::string text;
};

/// A topic that no node of the cell has sent: the recorder makes its messages.
struct MadeTopic {
  std::string name;        ///< "/joint_states"
  std::string type;        ///< "sensor_msgs/msg/JointState"
  std::string definition;  ///< of the type, as `ros2msg`
  StringMap metadata;      ///< of the channel
  bool latched = false;    ///< a file of a row begins with its last message
};

/// A sample with what the network does not tell.
struct RecordedSample {
  bus::RawSample sample;
  std::string node;            ///< of the writer; empty: unknown
  std::uint64_t log_time = 0;  ///< when it was received, since 1970 [ns]
};

/// For one thread. Functions throw RecordingError when a file cannot be written; then only the destructor may follow,
/// which leaves all files readable. No file remains of one that could not be begun.
class Recording {
 public:
  static constexpr std::chrono::seconds kFlush{1};     ///< a sample is on the disk after this time at most
  static constexpr std::size_t kMostChannels = 32768;  ///< further writers of a file share a channel of their topic
  /// Name of the attachment that a recording of a simulation has.
  static constexpr std::string_view kSimulation = "simulation.json";
  static constexpr std::string_view kReport = "recorder/report";        ///< JSON: figures and losses so far
  static constexpr std::string_view kWithdrawn = "recorder/withdrawn";  ///< JSON: keys that writers have retired
  static constexpr std::string_view kClocks = "recorder/clocks";        ///< JSON: offsets of the hosts' clocks

  /// Creates the first file. Each file gets a copy of all `attachments`. `now`: since 1970 [ns].
  Recording(RecordingOptions options, std::vector<AttachedFile> attachments, std::uint64_t now);

  void write(RecordedSample sample);
  /// A message of channel kReport. The text also becomes the metadata of each file that is closed.
  void report(const std::string& json, std::uint64_t now);
  /// A message of channel kClocks.
  void compare_clocks(const std::string& json, std::uint64_t now) { write_json(kClocks, json, now); }
  /// Call it at most once. The topics have the numbers 0, 1 … of write_made().
  void set_made_topics(std::vector<MadeTopic> topics);
  void write_made(std::size_t topic, ByteSpan cdr, std::uint64_t now);
  /// Puts onto the disk what is older than kFlush, begins another file and removes old ones, as the options say. Call
  /// it several times a second.
  void keep_up(std::uint64_t now);
  /// Saves the files that are there now, and those that begin before `until` [ns]: `keep` does not remove them.
  void save(std::uint64_t until);
  void close();

  [[nodiscard]] std::uint64_t messages() const { return messages_; }  ///< of topics, in all files
  [[nodiscard]] std::uint64_t bytes() const { return closed_bytes_ + (file_ ? file_->size() : 0); }
  /// Removes the files that it made, after close(). A file that has taken the name of one stays.
  void remove_files();
  [[nodiscard]] std::vector<std::string> files() const;  ///< that exist, the oldest first

 private:
  /// Topic, writer, and whether its samples repeat those of a former file.
  using ChannelKey = std::tuple<std::size_t, bus::EndpointId, bool>;
  /// A file of the row.
  struct Segment {
    std::string path;
    FileIdentity identity;
    std::uint64_t ended = 0;  ///< [ns]
    std::uint64_t bytes = 0;
    bool saved = false;
  };

  struct Made {
    MadeTopic about;
    std::uint16_t channel = 0;  ///< of the open file; 0: none yet
    std::uint32_t written = 0;
    Bytes last;  ///< of a latched topic
  };

  void begin_file(std::uint64_t now);
  void end_file();
  void remove_old(std::uint64_t now);
  void remove_excess();
  void remove(const Segment& segment);
  void write_to_file(const RecordedSample& recorded, bool repeated);
  [[nodiscard]] std::uint16_t channel_of(const RecordedSample& recorded, bool repeated);
  void write_made_to_file(Made& made, ByteSpan cdr, std::uint64_t now);
  void write_json(std::string_view topic, const std::string& json, std::uint64_t now);

  RecordingOptions options_;
  std::vector<AttachedFile> attachments_;
  std::unique_ptr<McapWriter> file_;              ///< null after close()
  std::uint64_t began_ = 0;                       ///< the open file [ns]
  std::uint64_t flushed_ = 0;                     ///< [ns]
  std::uint64_t saved_until_ = 0;                 ///< [ns]
  int number_ = 0;                                ///< of the open file
  std::deque<Segment> segments_;                  ///< those before the open file
  std::map<std::size_t, std::uint16_t> schemas_;  ///< of the open file, by topic
  std::map<ChannelKey, std::uint16_t> channels_;  ///< of the open file
  std::map<std::string, std::uint16_t, std::less<>> json_channels_;
  std::vector<Made> made_;
  std::map<std::string, std::uint16_t> made_schemas_;  ///< of the open file, by type
  /// What late joiners of the cell would get: a file of a row begins with it.
  std::map<std::pair<std::size_t, std::string>, RecordedSample> latched_;
  std::optional<std::string> report_;  ///< the newest one
  std::uint64_t messages_ = 0;
  std::uint64_t closed_bytes_ = 0;
  std::uint64_t attached_bytes_ = 0;  ///< size of the open file before its first message
};

/// The files that former recordings of this cell have left in the folder of `row`, a path such as
/// "folder/cell-20261128T065430Z.mcap"; the oldest first. They bear such names, and Hecaton wrote them.
[[nodiscard]] std::vector<std::string> former_files(const std::string& row, const std::string& cell);

}  // namespace hecaton::services::recorder
