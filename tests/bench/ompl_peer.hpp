#pragma once
/// The peer of the global planner: OMPL's RRT-Connect with FCL's collision checks.

#include <vector>

#include "tests/support/fcl_collision_checker.hpp"

namespace hecaton::bench {

struct OmplPlan {
  bool solved = false;
  std::vector<std::vector<double>> path;
  double plan_us = 0.0;      ///< processor time of the search [µs]
  double simplify_us = 0.0;  ///< of the shortening [µs]
};

/// Whether OMPL shortens the path that it finds.
enum class OmplShortening { kNone, kSimplify };

/// Straight ways are checked at the validity's own step. The search ends by an explicit condition: solved, or `seconds`
/// have passed (OMPL's solve(seconds) would start a thread for its clock). So does the shortening, after `seconds`
/// more.
[[nodiscard]] OmplPlan plan_with_ompl(const planner::global::Validity& validity, test::FclCollisionChecker& checker,
                                      const std::vector<double>& start, const std::vector<double>& goal, double seconds,
                                      OmplShortening shortening = OmplShortening::kNone);

}  // namespace hecaton::bench
