#pragma once
/// The messages of ROS 2 of a cell as they fall due, at the rates of hecaton-ros2. For files: a recording
/// (services/recorder/ros2_track.hpp) and a bag (services/replay/ros2_bag.hpp). It knows no network and no file.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "services/ros2_messages/cdr.hpp"
#include "services/view/ros2_scene.hpp"

namespace hecaton::services {

/// For one thread. The cell's times are Unix times.
class Ros2Stream {
 public:
  /// Takes a message of the topic of this index in topics().
  using Sink = std::function<void(std::size_t topic, const std::vector<std::uint8_t>& cdr)>;

  /// `file` must outlive it.
  explicit Ros2Stream(const config::CellFile& file);

  [[nodiscard]] const std::vector<Ros2Topic>& topics() const { return topics_; }
  /// Between two calls of write_due().
  [[nodiscard]] bus::Clock::duration period() const;

  /// What never changes: descriptions of the robots, and transforms.
  void write_fixed(bus::Clock::time_point at, const Sink& sink);
  /// What is due at a time, from the newest of the cell until then.
  void write_due(const CellState& cell, bus::Clock::time_point at, const Sink& sink);

  /// The text of `ros2msg` that defines the type of a topic.
  [[nodiscard]] static std::string definition(const Ros2Topic& topic);
  /// What rosbag2 reads of a topic's channel. A player sends the topic with this QoS.
  [[nodiscard]] static std::map<std::string, std::string> channel_metadata(const Ros2Topic& topic);
  [[nodiscard]] static std::string qos_text(bool latched);

 private:
  template <class Message>
  void write(std::size_t topic, const Message& message, const Sink& sink);
  [[nodiscard]] bool due(std::size_t timer, bus::Clock::time_point at, bus::Clock::duration period);

  const config::CellFile& file_;
  std::vector<Ros2Topic> topics_;
  Ros2Scene scene_;
  std::array<bus::Clock::time_point, 3> due_{};
  ros2::Bytes bytes_;
};

}  // namespace hecaton::services
