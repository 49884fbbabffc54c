#include "planner/local/old_news.hpp"

#include <algorithm>
#include <cmath>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {

// Constant velocity:  q + q̇ τ.   Stop profile:  q̇(t) = q̇ (1 − t/T), so  q + q̇ (t − t²/2T)  with t = min(τ, T).
void extrapolate(const JointLimits& limits, ArmObservation& arm) {
  if (arm.plans) {
    if (arm.age > 0.0) arm.q += arm.qd * arm.age;
  } else {
    const double T = stop_time(limits, arm.qd);
    const double t = std::min(arm.age, T);
    if (T > 0.0) arm.q += arm.qd * (t - 0.5 * t * t / T);
    arm.qd = braking_velocity(limits, arm.qd, arm.age);
  }
  arm.q = arm.q.cwiseMax(limits.lower).cwiseMin(limits.upper);
}

world::ObstacleState extrapolated(const world::ObstacleState& then) {
  return {world::extrapolate(then.X_WO, then.velocity, then.age), then.velocity, then.age};
}

double least_distance(const AgedPair& pair) {
  return pair.distance - 0.5 * pair.other_acceleration * pair.age * pair.age;
}

// When the state was true the pair had x = d − dₛ + (v_own + v_other) τ to go. Since then, with the other at its bound,
//   ẋ = −v_own − k x   ⇒   x(τ) = x e^(−kτ) − v_own (1 − e^(−kτ))/k
// Both bounds hold, so the nearer of them is too pessimistic; what was expected is never exceeded.
double least_distance(const AgedPair& pair, double security_distance, double slope) {
  const double decay = std::exp(-slope * pair.age);
  const double then = pair.distance - security_distance + (pair.own_speed + pair.other_speed) * pair.age;
  const double damped = security_distance + then * decay - pair.own_speed * (1.0 - decay) / slope;
  return std::min(pair.distance, std::max(damped, least_distance(pair)));
}

}  // namespace hecaton::planner
