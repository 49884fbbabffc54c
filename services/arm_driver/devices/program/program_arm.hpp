#pragma once
/// An arm that a separate program moves, in any language: it reads DeviceCommand and writes DeviceState
/// (docs/how-to/move-an-arm-with-your-program.md). The driver's checks and its stop profile apply as for each device.

#include <memory>
#include <string>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

[[nodiscard]] std::unique_ptr<ArmDevice> make_program_arm(const DeviceSetup& setup);
/// Says what must stop the arm when the driver dies.
[[nodiscard]] std::vector<std::string> program_notes(const DeviceSetup& setup, const planner::RobotModel& model);

}  // namespace hecaton::device
