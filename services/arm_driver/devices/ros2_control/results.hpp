#pragma once
/// What the results of an action say, for people.

#include <string>

#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::device::ros2_control {

/// Why a trajectory ended, and what a person does: printable, not empty. Any code and text of the network is allowed.
[[nodiscard]] std::string reason_of(const ros2::TrajectoryResult& result);

}  // namespace hecaton::device::ros2_control
