#pragma once
/// Makes a path short: sampling planners' paths wander.

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

struct SimplifyOptions {
  int rounds = 40;  ///< random shortcuts that are tried after the greedy ones
  std::uint64_t seed = 1;
  EdgeCheck check = {};
  /// Wanted from the world beyond the validity's padding, where the path has it, so far as it has it: no shortcut is
  /// nearer to the world than the nearest of what it replaces. In three grades: all of it, a quarter of it, none [m].
  double clearance = 0.0;
  std::function<bool()> ended =
      {};  ///< asked before every check of a straight way: then the path stays as it is by now
};

/// A path with the same ends whose straight ways pass the check as those of `path` do, and that is not longer: first
/// every point is joined with the farthest one that it sees, then random pairs of points on the path [Geraerts07].
[[nodiscard]] Points simplified(const Points& path, const Validity& validity, const Space& space,
                                const SimplifyOptions& options = {});

/// Joint-space length [rad | m].
[[nodiscard]] double length(const Points& path, const Space& space);

}  // namespace hecaton::planner::global
