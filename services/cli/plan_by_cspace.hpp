#pragma once
/// `hecaton plan --method` of a method by which the arm itself goes its way, in virtual time.

#include <string>

#include "planner/global/plan.hpp"
#include "services/cli/plan_query.hpp"

namespace hecaton::services::cli {

/// How it went.
struct CspaceWalk {
  planner::global::Plan plan;  ///< iterations: searches; checks: control periods; nodes: points that it knows
  double duration = 0.0;       ///< virtual [s]
  int pictures = 0;
};

/// The arm goes by `method` from start to goal, everything else stands still; `seed` of its sensors' noise. A plan that
/// is not solved says why, in the arm's own words. `plot`: folder for its pictures, step by step; empty: none. Throws
/// Failure when the query is for several arms, when the arm's cell does not suit the method, and when a picture cannot
/// be written.
[[nodiscard]] CspaceWalk plan_by_cspace(const PlanQuery& query, const planner::global::Validity& validity,
                                        const std::string& method, std::uint64_t seed, const std::string& plot);

}  // namespace hecaton::services::cli
