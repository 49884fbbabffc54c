#include "services/replay/ros2_bag.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>

#include "services/recorder/mcap_writer.hpp"
#include "services/replay/recorded_cell.hpp"
#include "services/view/ros2_stream.hpp"

namespace hecaton::services::replay {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = bus::Clock;

/// As a text of YAML in one line.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text)
    out += c == '\n' ? "\\n" : c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
}

std::uint64_t nanoseconds(Clock::time_point at) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, at.time_since_epoch() / 1ns));
}

/// The folder, which is removed again unless keep() is called.
class NewFolder {
 public:
  explicit NewFolder(fs::path path) : path_(std::move(path)) {
    std::error_code error;
    if (fs::exists(fs::symlink_status(path_, error))) {
      throw recorder::RecordingError(path_.string() + " exists already: name a folder that does not exist");
    }
    if (!fs::create_directories(path_, error)) {
      throw recorder::RecordingError(path_.string() + " cannot be made: " + error.message());
    }
  }
  ~NewFolder() {
    std::error_code error;
    if (!kept_) fs::remove_all(path_, error);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  void keep() { kept_ = true; }

 private:
  fs::path path_;
  bool kept_ = false;
};

class BagExport {
 public:
  BagExport(const RecordingIndex& index, const config::CellFile& file, const fs::path& folder)
      : folder_(folder),
        bag_name_(folder.filename().string() + "_0.mcap"),
        begin_(index.begin),
        end_(index.end),
        made_(folder),
        cell_(index),
        stream_(file),
        writer_(std::make_unique<recorder::McapWriter>((folder / bag_name_).string(), "hecaton", "ros2")) {
    for (const Ros2Topic& topic : stream_.topics()) {
      const std::uint16_t schema = writer_->add_schema(topic.type, "ros2msg", Ros2Stream::definition(topic));
      channels_.push_back(
          {topic, writer_->add_channel(schema, topic.name, "cdr", Ros2Stream::channel_metadata(topic)), 0});
    }
  }

  std::vector<Ros2BagTopic> run(const std::function<void(double)>& progress) {
    const auto write = [this](std::size_t topic, const recorder::Bytes& cdr) {
      Channel& channel = channels_[topic];
      const auto sequence = static_cast<std::uint32_t>(++channel.messages);
      writer_->write({channel.id, sequence, nanoseconds(at_), nanoseconds(at_), cdr});
    };
    at_ = begin_;
    stream_.write_fixed(begin_, write);
    const Clock::duration period = stream_.period();
    int step = 0;
    for (Clock::time_point at = begin_;; at = std::min(at + period, end_)) {
      cell_.move_to(at);
      at_ = at;
      stream_.write_due(cell_.state(), at, write);
      if (progress && ++step % 500 == 0) progress((at - begin_) / std::chrono::duration<double>(end_ - begin_));
      if (at == end_) break;
    }
    writer_->close();
    write_metadata();
    made_.keep();
    std::vector<Ros2BagTopic> topics;
    for (const Channel& channel : channels_) {
      topics.push_back({channel.topic.name, channel.topic.type, channel.messages});
    }
    return topics;
  }

 private:
  struct Channel {
    Ros2Topic topic;
    std::uint16_t id = 0;
    std::uint64_t messages = 0;
  };

  /// Version 5 of rosbag2, which Humble writes and later releases read.
  void write_metadata() {
    std::uint64_t messages = 0;
    for (const Channel& channel : channels_) messages += channel.messages;
    const std::string duration = "nanoseconds: " + std::to_string(nanoseconds(end_) - nanoseconds(begin_));
    const std::string start = "nanoseconds_since_epoch: " + std::to_string(nanoseconds(begin_));
    const std::string count = "message_count: " + std::to_string(messages) + "\n";
    const fs::path path = folder_ / "metadata.yaml";
    std::ofstream out(path, std::ios::binary);
    out << "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    " << duration
        << "\n  starting_time:\n    " << start << "\n  " << count << "  topics_with_message_count:\n";
    for (const Channel& channel : channels_) {
      out << "    - topic_metadata:\n        name: " << channel.topic.name << "\n        type: " << channel.topic.type
          << "\n        serialization_format: cdr\n        offered_qos_profiles: "
          << quoted(Ros2Stream::qos_text(channel.topic.latched)) << "\n      message_count: " << channel.messages
          << "\n";
    }
    out << "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - " << quoted(bag_name_)
        << "\n  files:\n    - path: " << quoted(bag_name_) << "\n      starting_time:\n        " << start
        << "\n      duration:\n        " << duration << "\n      " << count;
    out.close();
    if (!out) throw recorder::RecordingError(path.string() + " cannot be written: " + std::strerror(errno));
  }

  fs::path folder_;
  std::string bag_name_;
  Clock::time_point begin_, end_;
  NewFolder made_;
  RecordedCell cell_;
  Ros2Stream stream_;
  std::unique_ptr<recorder::McapWriter> writer_;
  std::vector<Channel> channels_;  ///< in the order of Ros2Stream::topics()
  Clock::time_point at_;           ///< of the messages that are written
};

}  // namespace

std::vector<Ros2BagTopic> export_ros2_bag(const RecordingIndex& index, const config::CellFile& file,
                                          const std::string& folder,
                                          const std::function<void(double share)>& progress) {
  fs::path path = fs::path(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (path.empty()) throw recorder::RecordingError("the bag needs a folder that does not exist");
  return BagExport(index, file, path).run(progress);
}

}  // namespace hecaton::services::replay
