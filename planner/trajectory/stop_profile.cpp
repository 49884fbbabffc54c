#include "planner/trajectory/stop_profile.hpp"

#include <algorithm>

namespace hecaton::planner {

double stop_time(const JointLimits& limits, const JointVector& qd) {
  return qd.size() == 0 ? 0.0 : (qd.cwiseAbs().array() / limits.acceleration.array()).maxCoeff();
}

double longest_stop_time(const JointLimits& limits) {
  return stop_time(limits, limits.velocity);
}

JointVector braking_velocity(const JointLimits& limits, const JointVector& qd, double dt) {
  const double T = stop_time(limits, qd);
  return T <= dt ? JointVector(JointVector::Zero(qd.size())) : JointVector(qd * (1.0 - dt / T));
}

void stop_for(const JointLimits& limits, double t, JointVector& q, JointVector& qd) {
  const double T = stop_time(limits, qd);
  const double moving = std::min(t, T);
  if (T > 0.0) q += qd * (moving - 0.5 * moving * moving / T);
  qd = braking_velocity(limits, qd, t);
}

JointVector rest_position(const JointLimits& limits, const JointVector& q, const JointVector& qd) {
  return q + qd * (0.5 * stop_time(limits, qd));
}

}  // namespace hecaton::planner
