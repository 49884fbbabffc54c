#pragma once
/// Why no task could be drawn, in words. Each text is the end of a sentence.

#include <span>
#include <string>

#include "planner/cell.hpp"

namespace hecaton::planner {

/// A pair of bodies that was too near in draws of one arm.
struct Obstruction {
  std::string pair;       ///< "left/forearm and left/base"
  bool of_self = false;   ///< both belong to the arm
  double needed = 0.0;    ///< distance that starts and goals keep [m]
  double farthest = 0.0;  ///< the largest distance in those draws [m]
  int draws = 0;
};

/// Draws of one arm for one configuration of all arms.
struct DrawTally {
  int draws = 0;
  bool reached = false;  ///< the tool was in the task area
  bool clear = false;    ///< and the arm was clear of itself and of all places of obstacles
  Obstruction most_frequent = {};
};

/// `tallies`: one per arm, or none.
[[nodiscard]] std::string why_no_configuration(const Cell& cell, std::span<const DrawTally> tallies);

/// `drawn`: number of configurations drawn as goals.
[[nodiscard]] std::string why_no_conflict(const Cell& cell, int drawn);

/// `drawn`: number of start times drawn.
[[nodiscard]] std::string why_no_start_time(const Cell& cell, int drawn);

}  // namespace hecaton::planner
