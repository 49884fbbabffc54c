#pragma once
/// An arm of Universal Robots, CB3 and e-Series (docs/how-to/universal-robots.md).

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

/// Keys of `device:` beside `type`.
inline const std::vector<std::string_view> kUniversalRobotsKeys{"robot_ip",       "reverse_port",   "pc_ip",
                                                                "timeout",        "lookahead_time", "gain",
                                                                "tracking_delay", "speed_slider",   "model"};

inline constexpr std::string_view kUniversalRobotsPorts =
    "digital_input, configurable_input, digital_output or configurable_output with a number 0 to 7, or tool_input, "
    "tool_output, analog_input, tool_analog_input or analog_output with a number 0 or 1, such as tool_output 0";
/// See DeviceType::signal.
[[nodiscard]] std::optional<SignalKind> universal_robots_signal(std::string_view port);
[[nodiscard]] std::unique_ptr<ArmDevice> make_universal_robots_arm(const DeviceSetup& setup);
[[nodiscard]] std::vector<ListeningPort> universal_robots_ports(const DeviceSetup& setup);
/// Its robot: two programs would end each other.
[[nodiscard]] std::vector<Claim> universal_robots_claims(const DeviceSetup& setup);
/// Says when the description of the robot has no calibration of a real arm.
[[nodiscard]] std::vector<std::string> universal_robots_notes(const DeviceSetup& setup,
                                                              const planner::RobotModel& model);

}  // namespace hecaton::device
