#pragma once
/// The URScript program that follows set-points on the robot, and the packets that the driver sends to it. Pure.
///
/// The program connects to the driver. A packet is 15 big-endian int32; set-points are in 1e-6 rad and 1e-6 rad/s:
///
///     0        time-out [ms]: the program ends when no packet follows within it
///     1        1: set-point, 2: end
///     2        for how long the set-point is valid [ms]: then the program brakes
///     3 … 8    q
///     9 … 14   qd
///
/// Between packets the program extrapolates with qd. It stops the arm on the stop profile of its limits, and ends, when
/// packets cease, when the connection closes, on the packet 2, and when a set-point is farther from the last one than
/// the arm can move meanwhile.

#include <chrono>
#include <string>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::universal_robots {

struct ProgramSetup {
  std::string address;          ///< of this machine, as the robot reaches it
  int port = 0;                 ///< on which the driver listens
  double lookahead_time = 0.0;  ///< of servoj [s]
  double gain = 0.0;            ///< of servoj
  JointVector velocity;         ///< limits of six joints [rad/s]
  JointVector acceleration;     ///< limits of six joints [rad/s²]
};

[[nodiscard]] std::string program_text(const ProgramSetup& setup);

/// `timeout`: until the next packet. `valid_for`: of the set-point.
[[nodiscard]] std::string set_point_packet(const JointState& set_point, std::chrono::nanoseconds timeout,
                                           std::chrono::nanoseconds valid_for);
/// Ends the program; the arm stops.
[[nodiscard]] std::string end_packet();

}  // namespace hecaton::device::universal_robots
