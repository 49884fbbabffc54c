#pragma once
/// A cell in the messages of ROS 2, from the newest of what it has sent: live (foxglove/cell_server.hpp) or recorded
/// (services/replay/ros2_bag.hpp). It knows no network and no file.

#include <cstdint>
#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/ros2_messages/cell_messages.hpp"
#include "services/ros2_messages/cell_view.hpp"
#include "services/view/cell_state.hpp"

namespace hecaton::services {

/// For one thread. References that it returns are valid until the next update.
class Ros2Scene {
 public:
  /// `file` must outlive it.
  explicit Ros2Scene(const config::CellFile& file, ros2::CellEpoch epoch = ros2::CellEpoch::kBoot);

  /// Takes goals, and the arms' states that are new in `cell`.
  void update_states(const CellState& cell);
  /// Takes obstacles and plans, and draws the markers anew.
  void update_markers(const CellState& cell, const ros2::Time& stamp);

  [[nodiscard]] const ros2::CellView& view() const { return view_; }
  [[nodiscard]] const ros2::CellMarkers& markers() const { return markers_; }
  /// Mode, nodes and the newest faults at the time `now` of the cell's clock.
  [[nodiscard]] ros2::DiagnosticArray diagnostics(const CellState& cell, bus::Clock::time_point now,
                                                  const ros2::Time& stamp) const;

 private:
  const config::CellFile& file_;
  ros2::CellView view_;
  ros2::CellMarkers markers_;
  std::vector<bus::Clock::time_point> taken_;  ///< when the newest state of each arm was received
  std::uint64_t obstacle_edition_ = 0;         ///< last taken
};

/// A topic of the scene.
struct Ros2Topic {
  std::string name;
  std::string type;      ///< "sensor_msgs/msg/JointState"
  bool latched = false;  ///< readers that join later get its last message
};

/// The topics of a scene, as those of hecaton-ros2 (docs/reference/ros2.md): those of the cell in the order of
/// CellTopic, then those of each arm in the order of ArmTopic.
struct Ros2Topics {
  enum CellTopic : std::uint8_t {
    kDescription,
    kJointStates,
    kTransforms,
    kFixedTransforms,
    kDiagnostics,
    kMarkers,  ///< ros2::CellMarkers::kNames
  };
  enum ArmTopic : std::uint8_t { kArmDescription, kArmJointStates, kArmStatus, kArmTopics };

  [[nodiscard]] static std::size_t of_arm(std::size_t arm, ArmTopic topic) {
    return kMarkers + ros2::CellMarkers::kNames.size() + arm * kArmTopics + topic;
  }
  [[nodiscard]] static std::vector<Ros2Topic> all(const config::CellFile& file);
};

}  // namespace hecaton::services
