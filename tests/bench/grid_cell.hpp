#pragma once
/// Generated cells: any number of arms on a square grid, each in reach of its neighbours only.

#include "planner/cell.hpp"

namespace hecaton::bench {

/// Distance between neighbours [m]: less than what two arms reach together, more than what one does.
inline constexpr double kGridSpacing = 1.1;

/// `count` PUMA-sized arms of 6 capsules, row by row.
[[nodiscard]] std::vector<planner::Arm> grid_of_arms(int count);

}  // namespace hecaton::bench
