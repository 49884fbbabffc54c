#pragma once
/// The keys of a simulated arm.

#include <string_view>
#include <vector>

#include "planner/simulation/servo.hpp"
#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

inline const std::vector<std::string_view> kSimulatedKeys{
    "servo",   "servo_period", "dead_time",  "jitter",           "lag",
    "damping", "noise",        "resolution", "protective_speed", "protective_effort"};

struct SimulatedOptions {
  planner::ServoParameters servo;  ///< perfect without keys
  double protective_speed = 0.0;   ///< a faster joint causes a protective stop [rad/s | m/s]; 0: none does
  double protective_effort = 0.0;  ///< the same for a force, in limits of the drives (DriveForces); 0: none does
};
/// Throws std::runtime_error with a sentence.
[[nodiscard]] SimulatedOptions read_simulated_options(const DeviceSetup& setup);

}  // namespace hecaton::device
