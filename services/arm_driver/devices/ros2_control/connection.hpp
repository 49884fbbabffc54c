#pragma once
/// The topics of ROS 2 that a device uses: its own participant in the domain of the controllers.

#include <optional>
#include <vector>

#include "services/arm_driver/devices/ros2_control/action_client.hpp"
#include "services/arm_driver/devices/ros2_control/gripper.hpp"
#include "services/arm_driver/devices/ros2_control/options.hpp"
#include "services/arm_driver/devices/ros2_control/state_watch.hpp"
#include "services/bus/ros2_endpoint.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::device::ros2_control {

/// For one thread.
class Connection {
 public:
  /// Joins the domain. Throws std::runtime_error with a sentence when this fails.
  Connection(const Options& options, Clock::duration silence_limit);

  [[nodiscard]] std::vector<bus::ros2::Sample> joint_states() { return joint_states_.take(); }
  /// Nodes that publish joint states.
  [[nodiscard]] int broadcasters() const { return joint_states_.matched(); }
  /// Takes what the topics of speed scaling have.
  void update();

  /// The message must be of the type that the interface has. False: the middleware refuses it.
  bool send(const ros2::Float64MultiArray& message);
  bool send(const ros2::JointTrajectory& message, Clock::time_point now);
  /// A controller, or another node, reads commands or serves the action.
  [[nodiscard]] bool has_controller() const { return action_ ? action_->available() : commands_->matched() > 0; }
  /// Null: trajectories go to a topic.
  [[nodiscard]] TrajectoryAction* action() { return action_ ? &*action_ : nullptr; }
  [[nodiscard]] const TrajectoryAction* action() const { return action_ ? &*action_ : nullptr; }
  /// Null: the arm has no gripper.
  [[nodiscard]] Gripper* gripper() { return gripper_ ? &*gripper_ : nullptr; }
  [[nodiscard]] const Gripper* gripper() const { return gripper_ ? &*gripper_ : nullptr; }

  /// A trajectory controller has reported its state as often as before.
  [[nodiscard]] bool controller_runs(Clock::time_point now) const { return !states_.is_silent(now); }
  /// Of hardware and trajectory controller together, 0 to 1; empty: the configured topic is silent.
  [[nodiscard]] std::optional<double> speed_scaling(Clock::time_point now) const;

 private:
  Options options_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  bus::ros2::Reader joint_states_;
  std::optional<bus::ros2::Writer> commands_;
  std::optional<TrajectoryAction> action_;
  std::optional<Gripper> gripper_;
  std::optional<bus::ros2::Reader> controller_state_;  ///< of a trajectory controller
  std::optional<bus::ros2::Reader> scaling_input_;     ///< of a trajectory controller
  std::optional<bus::ros2::Reader> scaling_state_;     ///< of the hardware
  StateWatch states_;                                  ///< of a trajectory controller
  double scaling_of_controller_ = 1.0;
  double scaling_of_hardware_ = 1.0;
  std::optional<Clock::time_point> scaling_at_;  ///< of the hardware
  ros2::Bytes bytes_;
};

}  // namespace hecaton::device::ros2_control
