#include "planner/local/latency_compensation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/model/arm.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {

MeasuredState dead_reckoned(const JointLimits& limits, const OwnArmFeedback& feedback, double period) {
  MeasuredState now = feedback.state;
  const double due = feedback.follows ? std::clamp(period - feedback.setpoint_age, 0.0, feedback.age) : 0.0;
  now.q += now.qd * due;
  stop_for(limits, feedback.age - due, now.q, now.qd);
  return now;
}

void extrapolate(const JointLimits& limits, ArmObservation& arm) {
  if (!arm.plans && !arm.foreign) {
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

// At the time of the measurement the distance to dₛ was x = d − dₛ + (v_own + v_other) τ. The other body keeps its
// damper:
//
//     ẋ = −v_own − k x   ⇒   x(τ) ≥ x e^(−kτ) − v_fastest (1 − e^(−kτ))/k
//
// Both bounds hold, so the larger one applies, but never more than the expected distance.
double least_distance(const AgedPair& pair, double security_distance, double slope) {
  const double decay = std::exp(-slope * pair.age);
  const double then = pair.distance - security_distance + (pair.own_speed + pair.other_speed) * pair.age;
  const double damped = security_distance + then * decay - pair.own_fastest * (1.0 - decay) / slope;
  return std::min(pair.distance, std::max(damped, least_distance(pair)));
}

SetpointLog::SetpointLog(JointLimits limits, double period) : limits_(std::move(limits)), period_(period) {}

void SetpointLog::sent(std::uint64_t number, const MeasuredState& setpoint) {
  ring_[number % ring_.size()] = {number, setpoint};
}

std::optional<MeasuredState> SetpointLog::reference(std::uint64_t number, double age) const {
  const auto holds = [this](std::uint64_t one) { return one > 0 && ring_[one % ring_.size()].number == one; };
  if (!holds(number)) return std::nullopt;
  for (; age < 0.0 && holds(number - 1); --number) age += period_;
  MeasuredState reference = ring_[number % ring_.size()].setpoint;
  const double overdue = age - period_;
  if (overdue <= 0.0) {
    reference.q += reference.qd * overdue;
  } else {
    stop_for(limits_, overdue, reference.q, reference.qd);
  }
  return reference;
}

namespace {

/// Largest displacement of a joint in its positive direction [rad | m], from rate `v`. The joint accelerates at its
/// limit for `moved_for` [s], then stops within `stop` [s].
double farthest(double v, double most, double acceleration, double moved_for, double stop) {
  const double fastest = std::min(most, v + acceleration * moved_for);
  const double speeding_up = (fastest - v) / acceleration;
  return 0.5 * (v + fastest) * speeding_up + fastest * (moved_for - speeding_up) + 0.5 * std::max(0.0, fastest) * stop;
}

}  // namespace

ReachableStopSet reachable_stop_set(const JointLimits& limits, const JointVector& q, const JointVector& qd,
                                    double moved_for) {
  // All joints brake together, for as long as the slowest of them needs.
  const JointVector fastest = (qd.cwiseAbs() + limits.acceleration * moved_for).cwiseMin(limits.velocity);
  const double stop = stop_time(limits, fastest);
  ReachableStopSet region{q, q};
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double most = limits.velocity[j];
    const double v = std::clamp(qd[j], -most, most);
    const double a = limits.acceleration[j];
    const double up = std::min(limits.upper[j], q[j] + farthest(v, most, a, moved_for, stop));
    const double down = std::max(limits.lower[j], q[j] - farthest(-v, most, a, moved_for, stop));
    region.q[j] = 0.5 * (up + down);
    region.position_uncertainty[j] = std::max(0.0, 0.5 * (up - down));
  }
  return region;
}

// The distance of a point from the axis of an earlier joint is at most the summed length of the links in between.
JointVector longest_levers(const Arm& arm, int link, double extent) {
  const RobotModel& model = *arm.model;
  const std::vector<double> along = arm_reach(arm).links;
  JointVector levers = JointVector::Zero(model.joints());
  for (int i = moved_link(model, link); i >= 0; i = moved_link(model, model.links[i].parent)) {
    const Link& at = model.links[i];
    const double lever = at.joint_type == JointType::kPrismatic ? 1.0 : along[link] - along[i] + extent;
    levers[at.joint] += std::abs(at.multiplier) * lever;
  }
  return levers;
}

}  // namespace hecaton::planner
