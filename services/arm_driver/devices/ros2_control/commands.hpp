#pragma once
/// Set-points as messages of ROS 2. No network.

#include <string>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::device::ros2_control {

/// For a forward command controller: a value for each joint [rad | m], [rad/s | m/s].
[[nodiscard]] ros2::Float64MultiArray values_of(const JointVector& joints);

/// For a joint trajectory controller: reach the set-point after `lookahead` [s], then stop on the stop profile of the
/// driver. It starts when it arrives. Its last point is at rest.
[[nodiscard]] ros2::JointTrajectory stopping_trajectory(const std::vector<std::string>& joints,
                                                        const JointState& set_point, double lookahead,
                                                        const JointLimits& limits);

}  // namespace hecaton::device::ros2_control
