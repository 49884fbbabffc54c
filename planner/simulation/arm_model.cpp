#include "planner/simulation/arm_model.hpp"

#include <utility>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Position error is corrected with this rate [1/s].
constexpr double kTrackingGain = 30.0;
/// Share of the acceleration limit that a correction may need to end without overshoot.
constexpr double kCorrectionShare = 0.5;

}  // namespace

ServoedJoints::ServoedJoints(JointLimits limits, const JointVector& q)
    : limits_(std::move(limits)), state_{q, JointVector::Zero(q.size())} {}

// The velocity over this step that ends on the set-point, corrected towards it.
void ServoedJoints::follow(const JointState& set_point, double dt) {
  const JointVector error = set_point.q - (state_.q + 0.5 * (state_.qd + set_point.qd) * dt);
  advance_within_limits(limits_, set_point.qd + correction(error), dt, state_);
}

void ServoedJoints::brake(double dt) {
  advance_within_limits(limits_, braking_velocity(limits_, state_.qd, dt), dt, state_);
  if (state_.qd.isZero()) state_.qd.setZero();  // up to rounding
}

JointVector ServoedJoints::correction(const JointVector& error) const {
  const JointVector linear = kTrackingGain * error;
  const JointVector fastest =
      (2.0 * kCorrectionShare * limits_.acceleration.cwiseProduct(error.cwiseAbs())).cwiseSqrt();
  return linear.cwiseMax(-fastest).cwiseMin(fastest);
}

ArmModel::ArmModel(const JointLimits& limits, const JointVector& q, double command_timeout)
    : interpolator_(limits, q, command_timeout), joints_(limits, q) {}

// The joints brake as the interpolator does, from the same state: following it would add rounding.
void ArmModel::step(double dt) {
  const JointState& set_point = interpolator_.step(dt, joints_.state());
  if (interpolator_.mode() == DriveMode::kTracking) {
    joints_.follow(set_point, dt);
  } else {
    joints_.brake(dt);
  }
}

bool ArmModel::command(const JointVector& q, const JointVector& qd, double period) {
  return interpolator_.command({{q, qd}, period}, joints_.state());
}

}  // namespace hecaton::planner
