#include "services/replay/ros2_bag.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>

#include "services/recorder/mcap_writer.hpp"
#include "services/replay/recorded_cell.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/ros2_messages/schema.hpp"
#include "services/view/ros2_scene.hpp"

namespace hecaton::services::replay {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = bus::Clock;

/// The QoS of a topic as rosbag2 writes it since Humble: 1 is keep_last, reliable, transient_local and automatic, 2
/// volatile. A player sends the topic with it.
std::string qos_text(bool latched) {
  const std::string forever = "\n    sec: 9223372036\n    nsec: 854775807\n";
  return std::string("- history: 1\n  depth: ") + (latched ? "1" : "10") +
         "\n  reliability: 1\n  durability: " + (latched ? "1" : "2") + "\n  deadline:" + forever +
         "  lifespan:" + forever + "  liveliness: 1\n  liveliness_lease_duration:" + forever +
         "  avoid_ros_namespace_conventions: false\n";
}

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
      : file_(file),
        folder_(folder),
        bag_name_(folder.filename().string() + "_0.mcap"),
        begin_(index.begin),
        end_(index.end),
        made_(folder),
        cell_(index),
        scene_(file, ros2::CellEpoch::kUnix),
        writer_(std::make_unique<recorder::McapWriter>((folder / bag_name_).string(), "hecaton", "ros2")) {
    for (const Ros2Topic& topic : Ros2Topics::all(file)) {
      const std::uint16_t schema = writer_->add_schema(topic.type, "ros2msg", ros2::message_definition(topic.type));
      const recorder::StringMap metadata{{"offered_qos_profiles", qos_text(topic.latched)}, {"topic_type_hash", ""}};
      channels_.push_back({topic, writer_->add_channel(schema, topic.name, "cdr", metadata), 0});
    }
  }

  std::vector<Ros2BagTopic> run(const std::function<void(double)>& progress) {
    write_fixed();
    const auto period = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(file_.ros2.value_or(config::Ros2{}).period));
    int step = 0;
    for (Clock::time_point at = begin_;; at = std::min(at + period, end_)) {
      cell_.move_to(at);
      at_ = at;
      write_due();
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

  template <class Message>
  void write(std::size_t topic, const Message& message) {
    ros2::encode(message, bytes_);
    Channel& channel = channels_[topic];
    const auto sequence = static_cast<std::uint32_t>(++channel.messages);
    writer_->write({channel.id, sequence, nanoseconds(at_), nanoseconds(at_), bytes_});
  }

  [[nodiscard]] bool due(std::size_t timer, Clock::duration period) {
    if (at_ < due_[timer]) return false;
    due_[timer] = at_ + period;
    return true;
  }

  void write_fixed() {
    at_ = begin_;
    write(Ros2Topics::kDescription, ros2::String{ros2::cell_urdf(file_.cell)});
    for (std::size_t i = 0; i < file_.cell.arms.size(); ++i) {
      write(Ros2Topics::of_arm(i, Ros2Topics::kArmDescription), ros2::String{ros2::arm_urdf(file_.cell.arms[i].arm)});
    }
    write(Ros2Topics::kFixedTransforms, ros2::fixed_transforms(file_.cell, scene_.view().time_at(begin_)));
  }

  void write_due() {
    const CellState& state = cell_.state();
    scene_.update_states(state);
    const ros2::CellView& view = scene_.view();
    if (const ros2::JointState all = ros2::joint_states(view, at_); !all.name.empty()) {
      write(Ros2Topics::kJointStates, all);
    }
    if (const ros2::TFMessage moving = ros2::moving_transforms(view, at_); !moving.transforms.empty()) {
      write(Ros2Topics::kTransforms, moving);
    }
    for (std::size_t i = 0; i < view.size(); ++i) {
      const ros2::ArmSnapshot arm = view.arm(i);
      if (ros2::is_shown(arm, at_)) {
        write(Ros2Topics::of_arm(i, Ros2Topics::kArmJointStates), ros2::joint_state(arm));
      }
    }
    if (due(0, ros2::kMarkerPeriod)) {
      scene_.update_markers(state, view.time_at(at_));
      for (std::size_t i = 0; i < ros2::CellMarkers::kNames.size(); ++i) {
        write(Ros2Topics::kMarkers + i, scene_.markers().message(i));
      }
    }
    if (due(1, ros2::kStatusPeriod)) {
      for (std::size_t i = 0; i < view.size(); ++i) {
        write(Ros2Topics::of_arm(i, Ros2Topics::kArmStatus), ros2::status_of(view.arm(i), at_));
      }
    }
    if (due(2, ros2::kDiagnosticsPeriod)) {
      write(Ros2Topics::kDiagnostics, scene_.diagnostics(state, at_, view.time_at(at_)));
    }
  }

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
          << quoted(qos_text(channel.topic.latched)) << "\n      message_count: " << channel.messages << "\n";
    }
    out << "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - " << quoted(bag_name_)
        << "\n  files:\n    - path: " << quoted(bag_name_) << "\n      starting_time:\n        " << start
        << "\n      duration:\n        " << duration << "\n      " << count;
    out.close();
    if (!out) throw recorder::RecordingError(path.string() + " cannot be written: " + std::strerror(errno));
  }

  const config::CellFile& file_;
  fs::path folder_;
  std::string bag_name_;
  Clock::time_point begin_, end_;
  NewFolder made_;
  RecordedCell cell_;
  Ros2Scene scene_;
  std::unique_ptr<recorder::McapWriter> writer_;
  std::vector<Channel> channels_;  ///< in the order of Ros2Topics::all()
  Clock::time_point at_;           ///< of the messages that are written
  std::array<Clock::time_point, 3> due_{};
  ros2::Bytes bytes_;
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
