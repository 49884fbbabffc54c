#pragma once
/// Says in sentences what bound an arm at one instant, from the messages that were received until then.

#include <string>
#include <vector>

#include "services/replay/recorded_cell.hpp"
#include "services/view/cell_state.hpp"

namespace hecaton::services::replay {

/// Which pairs of bodies bound the motion of an arm before an instant: the longest, and nearest to its goal. An arm
/// that goes around the body in its way meets others for longer.
struct LongestBinding {
  double window = 0.0;   ///< time before the instant that was looked at [s]
  double bound = 0.0;    ///< of it the pair bound the motion [s]; 0: no pair did, and all below is empty
  std::string own = {};  ///< body of the arm
  std::string other = {};
  double nearest = 0.0;      ///< the smallest distance to the goal of an arm that was bound [rad or m]
  double nearest_ago = 0.0;  ///< before the instant [s]
  std::string nearest_own = {};
  std::string nearest_other = {};
};

/// Looks at the goal that `arm` has at `at`, for the last ten seconds of it. Moves `cell` to `at`.
[[nodiscard]] LongestBinding longest_binding(RecordedCell& cell, const std::string& arm, bus::Clock::time_point at);

/// `arm`: of the cell. The sentences name the mode of the cell, what the arm does and why it stands, its goal, the pair
/// of bodies that bounds its motion, what its planner tries, the ages of its inputs, and open faults. With `before`
/// also the pairs that did before.
[[nodiscard]] std::vector<std::string> explain(const CellState& cell, const std::string& arm,
                                               bus::Clock::time_point now, const LongestBinding& before = {});

}  // namespace hecaton::services::replay
