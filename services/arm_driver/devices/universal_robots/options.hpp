#pragma once
/// The keys of `device: {type: universal_robots, …}` in the cell file.

#include <chrono>
#include <optional>
#include <string>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::universal_robots {

struct Options {
  std::string robot_ip;                 ///< IPv4
  int reverse_port = 0;                 ///< on which the driver waits for the robot's program
  std::optional<std::string> pc_ip;     ///< of this machine for the robot; empty: that of the connection to the robot
  std::chrono::nanoseconds timeout{0};  ///< silence of set-points after which the robot stops by itself
  double lookahead_time = 0.03;         ///< of servoj [s]
  double gain = 2000.0;                 ///< of servoj
  double tracking_delay = 0.0;          ///< lag of the arm behind set-points at full speed [s]
  std::chrono::nanoseconds command_timeout{0};  ///< of the cell: older data are a failure
  std::optional<double> speed_slider;           ///< set at each connection, 0 to 1; empty: it stays as it is
  std::optional<std::string> model;             ///< type that the robot must have, such as "ur5e"; empty: not known
};

/// Throws std::runtime_error with a sentence when a value cannot be used.
[[nodiscard]] Options read_options(const DeviceSetup& setup);

}  // namespace hecaton::device::universal_robots
