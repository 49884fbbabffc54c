#pragma once
/// The keys of `device: {type: abb_egm, …}` in the cell file.

#include <optional>
#include <string>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::abb_egm {

struct Options {
  int port = 0;                         ///< of UDP, to which the robot sends
  std::optional<std::string> robot_ip;  ///< IPv4; empty: that of the first sender
  /// Place of the joint that the controller has as an additional axis, from 0; empty: the arm has no such joint.
  std::optional<Eigen::Index> external_axis;
  double tracking_delay = 0.0;  ///< lag of the arm behind set-points [s]
};

/// Throws std::runtime_error with a sentence when a value cannot be used, and for an arm without six or seven joints.
[[nodiscard]] Options read_options(const DeviceSetup& setup);

}  // namespace hecaton::device::abb_egm
