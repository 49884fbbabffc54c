#pragma once
/// Makes a path short: sampling planners' paths wander.

#include "planner/global/search.hpp"

namespace hecaton::planner::global {

struct SimplifyOptions {
  int rounds = 40;  ///< random shortcuts that are tried after the greedy ones
  std::uint64_t seed = 1;
  int finer = 1;  ///< as SearchProblem's
};

/// A path with the same ends whose straight ways are free, too, and that is not longer: first every point is joined
/// with the farthest one that it sees, then random pairs of points on the path [Geraerts07].
[[nodiscard]] Points simplified(const Points& path, const Validity& validity, const Space& space,
                                const SimplifyOptions& options = {});

/// Joint-space length [rad | m].
[[nodiscard]] double length(const Points& path, const Space& space);

}  // namespace hecaton::planner::global
