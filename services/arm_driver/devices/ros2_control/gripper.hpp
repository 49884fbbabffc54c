#pragma once
/// The gripper of an arm in ros2_control: the action GripperCommand, or a forward command controller for positions.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/arm_driver/devices/ros2_control/action_client.hpp"
#include "services/arm_driver/devices/ros2_control/joint_states.hpp"
#include "services/arm_driver/devices/ros2_control/options.hpp"

namespace hecaton::device::ros2_control {

/// For one thread.
class Gripper {
 public:
  /// `silence_limit`: older joint states of the fingers are not used. Throws std::runtime_error with a sentence.
  Gripper(const GripperOptions& options, Clock::duration silence_limit, bus::Participant& participant,
          bus::Mailbox& mailbox);

  /// A serialised message of joint states.
  void take(const bus::ros2::Sample& sample);
  void update(Clock::time_point now);

  /// Measured positions of the fingers [rad | m]; empty: not known.
  [[nodiscard]] std::vector<double> positions(Clock::time_point now) const;
  /// Begins a motion of the fingers to `positions`, with at most that effort; negative: that of the cell file.
  [[nodiscard]] DeviceResult move(const std::vector<double>& positions, double effort, Clock::time_point now);
  /// The end of the motion, once: the fingers are there, or something has stopped them.
  [[nodiscard]] std::optional<OrderEnd> end();

 private:
  void take_result(const GripperAction::End& end);
  void watch(Clock::time_point now);
  void finish(DeviceResult result);

  GripperOptions options_;
  Clock::duration silence_limit_;
  std::optional<GripperAction> action_;
  std::optional<bus::ros2::Writer> commands_;
  JointStates states_;
  bool moves_ = false;
  std::vector<double> target_;
  std::vector<double> last_;         ///< positions of the fingers when one moved
  Clock::time_point began_, moved_;  ///< of the motion, and of the last change of a finger in it
  std::optional<OrderEnd> end_;
};

}  // namespace hecaton::device::ros2_control
