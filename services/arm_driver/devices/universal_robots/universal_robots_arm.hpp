#pragma once
/// An arm of Universal Robots, CB3 and e-Series (docs/how-to/universal-robots.md).

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

/// Keys of `device:` beside `type`.
inline const std::vector<std::string_view> kUniversalRobotsKeys{
    "robot_ip", "reverse_port", "pc_ip", "timeout", "lookahead_time", "gain", "tracking_delay", "speed_slider"};

[[nodiscard]] std::unique_ptr<ArmDevice> make_universal_robots_arm(const DeviceSetup& setup);
[[nodiscard]] std::vector<ListeningPort> universal_robots_ports(const DeviceSetup& setup);
/// Says when the description of the robot has no calibration of a real arm.
[[nodiscard]] std::vector<std::string> universal_robots_notes(const DeviceSetup& setup,
                                                              const planner::RobotModel& model);

}  // namespace hecaton::device
