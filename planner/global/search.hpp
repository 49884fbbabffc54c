#pragma once
/// What every sampling planner gets and gives. Each is one file: rrt_connect, rrt, est, prm.

#include <cstdint>
#include <functional>

#include "planner/global/space.hpp"
#include "planner/global/validity.hpp"

namespace hecaton::planner::global {

/// When a search gives up.
struct Budget {
  std::uint64_t iterations = 1'000'000;  ///< samples drawn
  std::function<bool()> ended;  ///< asked every now and then; empty: never. Has the clock that planners have not

  [[nodiscard]] bool over(std::uint64_t iteration) const {
    return iteration >= iterations || (ended && iteration % 64 == 63 && ended());
  }
};

struct SearchProblem {
  const Validity& validity;
  const Space& space;
  const float* start;  ///< free
  const float* goal;   ///< free
  std::uint64_t seed = 1;
  Budget budget = {};
};

struct SearchResult {
  bool solved = false;
  Points path;                   ///< start … goal; every straight way between two is free
  std::uint64_t iterations = 0;  ///< samples drawn
  int nodes = 0;                 ///< of all trees, or of the roadmap
};

/// [LaValle01]'s EXTEND, in its words ([Cardenas10] fig. 9).
enum class Extend { kTrapped, kAdvanced, kReached };

struct RrtOptions {
  float range = 2.0F;       ///< the longest new edge, in joint space [rad | m]
  float goal_bias = 0.05F;  ///< RRT: share of samples that are the goal
  /// Dynamic domain [Yershova05]: a node that failed to grow is extended to samples within this many radians only,
  /// fewer with every failure; 0: without.
  float domain = 4.0F;
  float domain_change = 1e-4F;  ///< relative, per success or failure
  float least_domain = 1.0F;
};

[[nodiscard]] SearchResult rrt_connect(const SearchProblem& problem, const RrtOptions& options = {});

}  // namespace hecaton::planner::global
