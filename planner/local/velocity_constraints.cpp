#include "planner/local/velocity_constraints.hpp"

#include <algorithm>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {

VelocityBounds speed_and_position_bounds(const JointLimits& limits, const JointVector& q, double dt) {
  // With q̇ = x/T the remaining distance x shrinks as fast as one period of the stop profile reduces q̇, for any motion
  // of the other joints: the bound can always be kept. T includes the period before the first reaction.
  const double slope = 1.0 / (longest_stop_time(limits) + dt);
  VelocityBounds bounds{-limits.velocity, limits.velocity};
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    bounds.upper[j] = std::clamp(slope * (limits.upper[j] - q[j]), -limits.velocity[j], limits.velocity[j]);
    bounds.lower[j] = std::clamp(slope * (limits.lower[j] - q[j]), -limits.velocity[j], limits.velocity[j]);
  }
  return bounds;
}

VelocityBounds acceleration_bounds(const JointLimits& limits, const JointVector& qd, const JointVector& braking,
                                   double dt) {
  VelocityBounds bounds{qd - limits.acceleration * dt, qd + limits.acceleration * dt};
  bounds.lower = bounds.lower.cwiseMin(braking);
  bounds.upper = bounds.upper.cwiseMax(braking);
  return bounds;
}

VelocityBounds intersect(const VelocityBounds& a, const VelocityBounds& b, const JointVector& braking) {
  return {a.lower.cwiseMax(b.lower).cwiseMin(braking), a.upper.cwiseMin(b.upper).cwiseMax(braking)};
}

}  // namespace hecaton::planner
