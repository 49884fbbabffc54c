#include "planner/methods/potential_field/potential.hpp"

#include <algorithm>

namespace hecaton::planner::potential {
namespace {

/// Nearer than this share of Q*, and inside, the potential goes on as a straight line: it has a gradient there, too.
constexpr double kNearest = 0.02;

}  // namespace

// [Cardenas10] eq. 2 and 6.
Potential attraction(double d, double goal_distance) {
  if (d <= goal_distance) return {0.5 * d * d, d};
  return {goal_distance * d - 0.5 * goal_distance * goal_distance, goal_distance};
}

// [Cardenas10] eq. 3 and 7:   U = ½ η (1/d − 1/Q*)²,   dU/dd = −η (1/d − 1/Q*) / d²
// differs from paper: eq. 7 prints the factor (1/d − 1/Q*) as squared, and without the sign that comes from
// differentiating 1/d: it would attract.
Potential repulsion(double d, double influence_distance, double repulsion) {
  if (d >= influence_distance) return {};
  const double at = std::max(d, kNearest * influence_distance);
  const double excess = 1.0 / at - 1.0 / influence_distance;
  const double slope = -repulsion * excess / (at * at);
  return {0.5 * repulsion * excess * excess + slope * (d - at), slope};
}

}  // namespace hecaton::planner::potential
