#pragma once
/// An arm of ABB that Externally Guided Motion (EGM) guides in joint space (docs/how-to/abb-egm.md).

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

/// Keys of `device:` beside `type`.
inline const std::vector<std::string_view> kAbbEgmKeys{"port", "robot_ip", "external_axis", "tracking_delay"};

[[nodiscard]] std::unique_ptr<ArmDevice> make_abb_egm_arm(const DeviceSetup& setup);
[[nodiscard]] std::vector<ListeningPort> abb_egm_ports(const DeviceSetup& setup);
/// Says to which port the robot has to send.
[[nodiscard]] std::vector<std::string> abb_egm_notes(const DeviceSetup& setup, const planner::RobotModel& model);

}  // namespace hecaton::device
