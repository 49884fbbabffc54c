#include "planner/local/latency_compensation.hpp"

#include <algorithm>
#include <cmath>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {

MeasuredState dead_reckoned(const JointLimits& limits, const OwnArmFeedback& news, double period) {
  MeasuredState now = news.state;
  const double due = news.follows ? std::clamp(period - news.setpoint_age, 0.0, news.age) : 0.0;
  now.q += now.qd * due;
  stop_for(limits, news.age - due, now.q, now.qd);
  return now;
}

// Constant velocity or stop profile.
void extrapolate(const JointLimits& limits, ArmObservation& arm) {
  if (!arm.plans) {
    stop_for(limits, arm.age, arm.q, arm.qd);
  } else if (arm.age > 0.0) {
    arm.q += arm.qd * arm.age;
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
