#pragma once
/// How often a driver publishes the state of its arm.

#include <algorithm>

#include "services/config/cell_file.hpp"

namespace hecaton::services {

/// The period of ArmState while nothing decisive changes [s]: that of the fastest loop that reads it, a planner's or
/// the world's. These extrapolate a state to their own instant.
[[nodiscard]] inline double state_period(const config::CellFile& file) {
  const auto& timing = file.cell.timing;
  return std::max(timing.driver_period, std::min(timing.control_period, timing.world_period));
}

}  // namespace hecaton::services
