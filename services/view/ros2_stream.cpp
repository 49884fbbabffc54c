#include "services/view/ros2_stream.hpp"

#include <chrono>

#include "services/ros2_messages/cell_description.hpp"
#include "services/ros2_messages/schema.hpp"

namespace hecaton::services {

using Clock = bus::Clock;

Ros2Stream::Ros2Stream(const config::CellFile& file)
    : file_(file), topics_(Ros2Topics::all(file)), scene_(file, ros2::CellEpoch::kUnix) {}

Clock::duration Ros2Stream::period() const {
  return std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(file_.ros2.value_or(config::Ros2{}).period));
}

std::string Ros2Stream::definition(const Ros2Topic& topic) {
  return ros2::message_definition(topic.type);
}

// As rosbag2 writes it since Humble: 1 is keep_last, reliable, transient_local and automatic, 2 volatile.
std::string Ros2Stream::qos_text(bool latched) {
  const std::string forever = "\n    sec: 9223372036\n    nsec: 854775807\n";
  return std::string("- history: 1\n  depth: ") + (latched ? "1" : "10") +
         "\n  reliability: 1\n  durability: " + (latched ? "1" : "2") + "\n  deadline:" + forever +
         "  lifespan:" + forever + "  liveliness: 1\n  liveliness_lease_duration:" + forever +
         "  avoid_ros_namespace_conventions: false\n";
}

std::map<std::string, std::string> Ros2Stream::channel_metadata(const Ros2Topic& topic) {
  return {{"offered_qos_profiles", qos_text(topic.latched)}, {"topic_type_hash", ""}};
}

template <class Message>
void Ros2Stream::write(std::size_t topic, const Message& message, const Sink& sink) {
  ros2::encode(message, bytes_);
  sink(topic, bytes_);
}

bool Ros2Stream::due(std::size_t timer, Clock::time_point at, Clock::duration period) {
  if (at < due_[timer]) return false;
  due_[timer] = at + period;
  return true;
}

void Ros2Stream::write_fixed(Clock::time_point at, const Sink& sink) {
  write(Ros2Topics::kDescription, ros2::String{ros2::cell_urdf(file_.cell)}, sink);
  for (std::size_t i = 0; i < file_.cell.arms.size(); ++i) {
    write(Ros2Topics::of_arm(i, Ros2Topics::kArmDescription), ros2::String{ros2::arm_urdf(file_.cell.arms[i].arm)},
          sink);
  }
  write(Ros2Topics::kFixedTransforms, ros2::fixed_transforms(file_.cell, scene_.view().time_at(at)), sink);
}

void Ros2Stream::write_due(const CellState& cell, Clock::time_point at, const Sink& sink) {
  scene_.update_states(cell);
  const ros2::CellView& view = scene_.view();
  if (const ros2::JointState all = ros2::joint_states(view, at); !all.name.empty()) {
    write(Ros2Topics::kJointStates, all, sink);
  }
  if (const ros2::TFMessage moving = ros2::moving_transforms(view, at); !moving.transforms.empty()) {
    write(Ros2Topics::kTransforms, moving, sink);
  }
  for (std::size_t i = 0; i < view.size(); ++i) {
    const ros2::ArmSnapshot arm = view.arm(i);
    if (ros2::is_shown(arm, at)) {
      write(Ros2Topics::of_arm(i, Ros2Topics::kArmJointStates), ros2::joint_state(arm), sink);
    }
  }
  if (due(0, at, ros2::kMarkerPeriod)) {
    scene_.update_markers(cell, view.time_at(at));
    for (std::size_t i = 0; i < ros2::CellMarkers::kNames.size(); ++i) {
      write(Ros2Topics::kMarkers + i, scene_.markers().message(i), sink);
    }
  }
  if (due(1, at, ros2::kStatusPeriod)) {
    for (std::size_t i = 0; i < view.size(); ++i) {
      write(Ros2Topics::of_arm(i, Ros2Topics::kArmStatus), ros2::status_of(view.arm(i), at), sink);
    }
  }
  if (due(2, at, ros2::kDiagnosticsPeriod)) {
    write(Ros2Topics::kDiagnostics, scene_.diagnostics(cell, at, view.time_at(at)), sink);
  }
}

}  // namespace hecaton::services
