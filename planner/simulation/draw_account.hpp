#pragma once
/// What draws of tasks met with, and in words why they found none: each text is the end of a sentence.

#include <span>
#include <string>

#include "planner/cell.hpp"

namespace hecaton::planner {

/// Of one arm, over the draws of one configuration of all arms.
struct DrawTally {
  int draws = 0;
  bool reached = false;  ///< its tool was in the task area
  bool clear = false;    ///< and the arm clear of itself and of everything that obstacles ever sweep
};

/// Why no configuration was found; `tallies` has one for each arm.
[[nodiscard]] std::string why_no_configuration(const Cell& cell, std::span<const DrawTally> tallies);

/// Why none of so many drawn configurations was a goal.
[[nodiscard]] std::string why_no_conflict(const Cell& cell, int drawn);

/// Why arms cannot begin at any of so many drawn instants.
[[nodiscard]] std::string why_no_instant(const Cell& cell, int drawn);

}  // namespace hecaton::planner
