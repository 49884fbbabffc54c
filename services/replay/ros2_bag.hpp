#pragma once
/// A recording as a bag of ROS 2 (a folder with metadata.yaml and an MCAP file), for `ros2 bag play`, RViz and
/// Foxglove: the topics of hecaton-ros2, as they would have been sent.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/replay/recording_index.hpp"

namespace hecaton::services::replay {

struct Ros2BagTopic {
  std::string name;
  std::string type;  ///< "sensor_msgs/msg/JointState"
  std::uint64_t messages = 0;
};

/// Writes the bag into `folder`, which must not exist. A joint's state has the time of its driver, the message that of
/// its arrival at the recorder. `progress`: called with the share that was written; empty: not called. Throws
/// RecordingError with a sentence; then no folder remains.
std::vector<Ros2BagTopic> export_ros2_bag(const RecordingIndex& index, const config::CellFile& file,
                                          const std::string& folder,
                                          const std::function<void(double share)>& progress = {});

}  // namespace hecaton::services::replay
