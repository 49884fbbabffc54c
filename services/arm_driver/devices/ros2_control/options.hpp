#pragma once
/// The keys of `device: {type: ros2_control, …}` in the cell file.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::ros2_control {

/// Keys of `device:` beside `type`.
inline const std::vector<std::string_view> kKeys{"domain",
                                                 "address",
                                                 "namespace",
                                                 "interface",
                                                 "controller",
                                                 "joints",
                                                 "joint_prefix",
                                                 "joint_states",
                                                 "lookahead",
                                                 "tracking_delay",
                                                 "speed_scaling",
                                                 "gripper_controller",
                                                 "gripper_interface",
                                                 "gripper_joints",
                                                 "gripper_effort"};

/// The kind of controller that gets the set-points.
enum class Interface {
  kPosition,    ///< a forward command controller for positions: each set-point as it is
  kVelocity,    ///< a forward command controller for velocities: the one of the set-point, and a correction
  kTrajectory,  ///< a joint trajectory controller: short trajectories that end at rest, on its topic
  kAction,      ///< the same trajectories as goals of the action FollowJointTrajectory
};

/// Else each message is one command.
[[nodiscard]] constexpr bool has_trajectories(Interface interface) {
  return interface == Interface::kTrajectory || interface == Interface::kAction;
}

struct GripperOptions {
  int domain = 0;                   ///< of DDS
  bool action = true;               ///< the action GripperCommand; else a forward command controller for positions
  std::string controller;           ///< full name of its node
  std::vector<std::string> joints;  ///< names of the fingers in ROS 2
  double effort = 0.0;              ///< max_effort of an order without a force [N | N m]
};

struct Options {
  int domain = 0;                      ///< of DDS: ROS_DOMAIN_ID of the controller
  std::optional<std::string> address;  ///< IPv4, of the network interface to use; empty: all
  Interface interface = Interface::kTrajectory;
  std::string controller;                    ///< full name of its node: "/left/joint_trajectory_controller"
  std::string joint_states;                  ///< topic with full name
  std::optional<std::string> speed_scaling;  ///< topic of std_msgs/msg/Float64 in percent, with full name
  std::vector<std::string> joints;           ///< names in the controller, in the order of the arm's joints
  double lookahead = 0.0;                    ///< time from a set-point to its place in the trajectory [s]
  double tracking_delay = 0.0;               ///< lag of the arm behind set-points [s]
  std::optional<GripperOptions> gripper;     ///< empty: the arm has none
};

/// Throws std::runtime_error with a sentence when a value cannot be used.
[[nodiscard]] Options read_options(const DeviceSetup& setup);

}  // namespace hecaton::device::ros2_control
