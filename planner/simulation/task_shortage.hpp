#pragma once
/// Why no task could be drawn, in words. Each text is the end of a sentence.

#include <span>
#include <string>

#include "planner/cell.hpp"

namespace hecaton::planner {

/// Draws of one arm for one configuration of all arms.
struct DrawTally {
  int draws = 0;
  bool reached = false;  ///< the tool was in the task area
  bool clear = false;    ///< and the arm was clear of itself and of all places of obstacles
};

/// `tallies`: one per arm, or none.
[[nodiscard]] std::string why_no_configuration(const Cell& cell, std::span<const DrawTally> tallies);

/// `drawn`: number of configurations drawn as goals.
[[nodiscard]] std::string why_no_conflict(const Cell& cell, int drawn);

/// `drawn`: number of start times drawn.
[[nodiscard]] std::string why_no_start_time(const Cell& cell, int drawn);

}  // namespace hecaton::planner
