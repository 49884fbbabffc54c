#include "planner/simulation/arm_model.hpp"

#include <utility>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
ServoedJoints::ServoedJoints(JointLimits limits, const JointVector& q)
    : limits_(std::move(limits)), state_{q, JointVector::Zero(q.size())} {}

void ServoedJoints::follow(const JointState& set_point, double dt) {
  follow_within_limits(limits_, set_point, dt, state_);
}

void ServoedJoints::brake(double dt) {
  advance_within_limits(limits_, braking_velocity(limits_, state_.qd, dt), dt, state_);
  if (state_.qd.isZero()) state_.qd.setZero();  // up to rounding
}

ArmModel::ArmModel(const JointLimits& limits, const JointVector& q, double command_timeout)
    : interpolator_(limits, q, command_timeout), joints_(limits, q) {}

ArmModel::ArmModel(const JointLimits& limits, const JointVector& q, double command_timeout,
                   const ServoParameters& servo, std::uint64_t seed)
    : ArmModel(limits, q, command_timeout) {
  if (!servo.perfect()) servo_.emplace(limits, servo, q, seed);
}

// When stopping, the joints brake from the same state as the interpolator. Following it would add rounding errors.
void ArmModel::step(double dt) {
  const JointState& set_point = interpolator_.step(dt, continues_from());
  if (servo_) {
    servo_->follow(set_point, dt);
  } else if (interpolator_.mode() == DriveMode::kTracking) {
    joints_.follow(set_point, dt);
  } else {
    joints_.brake(dt);
  }
}

bool ArmModel::command(const JointVector& q, const JointVector& qd, double period) {
  return interpolator_.command({{q, qd}, period}, continues_from());
}

}  // namespace hecaton::planner
