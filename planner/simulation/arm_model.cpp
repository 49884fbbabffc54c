#include "planner/simulation/arm_model.hpp"

#include <algorithm>
#include <utility>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Position error is corrected with this rate [1/s].
constexpr double kTrackingGain = 30.0;
/// Share of the acceleration limit that a correction may need to end without overshoot.
constexpr double kCorrectionShare = 0.5;

}  // namespace

ArmModel::ArmModel(JointLimits limits, JointVector q, double command_timeout)
    : limits_(std::move(limits)), q_(std::move(q)), command_timeout_(command_timeout) {
  qd_ = JointVector::Zero(q_.size());
}

bool ArmModel::command(const JointVector& q, const JointVector& qd, double period) {
  const bool far = ((q - q_).cwiseAbs().array() > limits_.velocity.array() * (command_timeout_ + period)).any();
  if (far) {
    stop();
    return false;
  }
  from_q_ = q_;
  from_qd_ = qd_;
  target_q_ = q.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  target_qd_ = qd.cwiseMax(-limits_.velocity).cwiseMin(limits_.velocity);
  if (target_q_ != q || target_qd_ != qd) ++clamped_;
  period_ = period;
  since_command_ = 0.0;
  mode_ = DriveMode::kTracking;
  return true;
}

void ArmModel::stop() {
  if (mode_ == DriveMode::kTracking) mode_ = DriveMode::kStopping;
}

void ArmModel::step(double dt) {
  if (mode_ == DriveMode::kTracking) {
    since_command_ += dt;
    if (since_command_ > command_timeout_) mode_ = DriveMode::kStopping;
  }
  if (mode_ == DriveMode::kTracking) {
    track(dt);
  } else {
    move(braking_velocity(limits_, qd_, dt), dt);
    if (qd_.isZero()) {  // up to rounding
      qd_.setZero();
      mode_ = DriveMode::kIdle;
    }
  }
}

JointVector ArmModel::correction(const JointVector& error) const {
  const JointVector linear = kTrackingGain * error;
  const JointVector fastest =
      (2.0 * kCorrectionShare * limits_.acceleration.cwiseProduct(error.cwiseAbs())).cwiseSqrt();
  return linear.cwiseMax(-fastest).cwiseMin(fastest);
}

// Between set-points the reference has constant acceleration, as the planner integrates it. A set-point that is due and
// has no successor is followed by the stop from it: the one continuation that the planner has found free. The drive
// adds a correction, no faster than it can brake away again, and clips to what the joints can do.
void ArmModel::track(double dt) {
  const JointVector acceleration = (target_qd_ - from_qd_) / period_;
  const double ahead = since_command_ - period_;  // < 0: the set-point is not due yet
  JointVector reference_q = target_q_;
  JointVector reference_qd = target_qd_;
  if (ahead < 0.0) {
    reference_q += target_qd_ * ahead + 0.5 * acceleration * ahead * ahead;
    reference_qd += acceleration * ahead;
  } else if (const double stop = stop_time(limits_, target_qd_); stop > 0.0) {
    const double braked = std::min(ahead, stop);
    reference_q += target_qd_ * braked * (1.0 - 0.5 * braked / stop);
    reference_qd *= 1.0 - braked / stop;
  }
  // The velocity over this step that ends on the reference, corrected towards it.
  const JointVector error = reference_q - (q_ + 0.5 * (qd_ + reference_qd) * dt);
  move(reference_qd + correction(error), dt);
}

void ArmModel::move(const JointVector& qd_next, double dt) {
  const JointVector step = limits_.acceleration * dt;
  JointVector next = qd_next.cwiseMax(qd_ - step).cwiseMin(qd_ + step);
  next = next.cwiseMax(-limits_.velocity).cwiseMin(limits_.velocity);
  q_ += 0.5 * (qd_ + next) * dt;
  qd_ = next;
  for (Eigen::Index j = 0; j < q_.size(); ++j) {  // the mechanical end stop
    if (q_[j] < limits_.lower[j] || q_[j] > limits_.upper[j]) {
      q_[j] = std::min(std::max(q_[j], limits_.lower[j]), limits_.upper[j]);
      qd_[j] = 0.0;
    }
  }
}

}  // namespace hecaton::planner
