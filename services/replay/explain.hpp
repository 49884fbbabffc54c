#pragma once
/// Says in sentences what bound an arm at one instant, from the messages that were received until then.

#include <string>
#include <vector>

#include "services/view/cell_state.hpp"

namespace hecaton::services::replay {

/// `arm`: of the cell. The sentences name the mode of the cell, what the arm does and why it stands, its goal, the pair
/// of bodies that bounds its motion, what its planner tries, the ages of its inputs, and open faults.
[[nodiscard]] std::vector<std::string> explain(const CellState& cell, const std::string& arm,
                                               bus::Clock::time_point now);

}  // namespace hecaton::services::replay
