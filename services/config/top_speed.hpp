#pragma once
/// How fast an arm's tool can get.

#include "planner/model/arm.hpp"

namespace hecaton::config {

/// The largest speed [m/s] of the tool frame's origin over random configurations and the joint velocities that the
/// limits allow: a lower bound that is near the truth. Deterministic.
[[nodiscard]] double top_tool_speed(const planner::Arm& arm);

}  // namespace hecaton::config
