#pragma once
/// An arm whose controllers run in ros2_control (docs/how-to/ros2-control.md). Nothing of ROS 2 is linked.

#include <memory>
#include <string>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/arm_driver/devices/ros2_control/options.hpp"

namespace hecaton::device {

[[nodiscard]] std::unique_ptr<ArmDevice> make_ros2_control_arm(const DeviceSetup& setup);
/// Its controller moves one arm.
[[nodiscard]] std::vector<Claim> ros2_control_claims(const DeviceSetup& setup);
/// True of a velocity controller: it keeps the last velocity.
[[nodiscard]] bool ros2_control_goes_on(const DeviceSetup& setup);
/// Names the topics and joints, and says what stops the arm when the driver dies.
[[nodiscard]] std::vector<std::string> ros2_control_notes(const DeviceSetup& setup, const planner::RobotModel& model);

}  // namespace hecaton::device
