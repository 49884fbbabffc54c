#pragma once
/// The queries of all methods: a PUMA 560 among boxes.

#include <vector>

#include "planner/global/plan.hpp"
#include "tests/support/fcl_collision_checker.hpp"

namespace hecaton::bench {

inline constexpr double kLongestSearch = 2.0;  ///< [s], of processor time

/// So much processor time of this thread from now on.
[[nodiscard]] std::function<bool()> processor_deadline(double seconds);

struct QueryScene {
  std::vector<planner::global::WorldBody> world;
  planner::global::Validity validity;

  struct Query {
    std::vector<double> start;
    std::vector<double> goal;
    double length = 0.0;  ///< of RRT-Connect's path, shortened: what others are compared with [rad]
  };
  std::vector<Query> queries;

  QueryScene(int boxes, planner::Random& random);
};

/// Free for the fast check and for FCL.
[[nodiscard]] std::vector<double> draw_free(const planner::global::Validity& validity,
                                            test::FclCollisionChecker& checker, planner::Random& random);

/// Random boxes leave closed pockets. A query counts if either planner has found a path with another seed.
[[nodiscard]] bool path_exists(const planner::global::Validity& validity, test::FclCollisionChecker& checker,
                               const std::vector<double>& start, const std::vector<double>& goal);

/// Ten scenes of 20 boxes with 20 queries each that the straight line does not solve. Deterministic.
[[nodiscard]] const std::vector<QueryScene>& query_set();

}  // namespace hecaton::bench
