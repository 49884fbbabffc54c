#include "planner/trajectory/set_point_interpolator.hpp"

#include <algorithm>
#include <utility>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {

void advance_within_limits(const JointLimits& limits, const JointVector& qd_next, double dt, JointState& state) {
  const JointVector step = limits.acceleration * dt;
  JointVector next = qd_next.cwiseMax(state.qd - step).cwiseMin(state.qd + step);
  next = next.cwiseMax(-limits.velocity).cwiseMin(limits.velocity);
  state.q += 0.5 * (state.qd + next) * dt;
  state.qd = next;
  for (Eigen::Index j = 0; j < state.q.size(); ++j) {
    if (state.q[j] < limits.lower[j] || state.q[j] > limits.upper[j]) {
      state.q[j] = std::min(std::max(state.q[j], limits.lower[j]), limits.upper[j]);
      state.qd[j] = 0.0;
    }
  }
}

SetPointInterpolator::SetPointInterpolator(JointLimits limits, const JointVector& q, double command_timeout)
    : limits_(std::move(limits)), command_timeout_(command_timeout) {
  reset(q);
}

void SetPointInterpolator::reset(const JointVector& q) {
  mode_ = DriveMode::kIdle;
  reference_ = {q, JointVector::Zero(q.size())};
}

bool SetPointInterpolator::command(const TimedSetPoint& set_point, const JointState& arm) {
  const auto& [q, qd] = set_point.target;
  const double late = command_timeout_ + set_point.period;
  if (((q - arm.q).cwiseAbs().array() > limits_.velocity.array() * late).any()) {
    stop(arm);
    return false;
  }
  from_qd_ = arm.qd;
  target_.q = q.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  target_.qd = qd.cwiseMax(-limits_.velocity).cwiseMin(limits_.velocity);
  if (target_.q != q || target_.qd != qd) ++clamped_;
  period_ = set_point.period;
  since_command_ = 0.0;
  mode_ = DriveMode::kTracking;
  return true;
}

void SetPointInterpolator::stop(const JointState& arm) {
  if (mode_ != DriveMode::kTracking) return;
  mode_ = DriveMode::kStopping;
  reference_ = arm;
}

const JointState& SetPointInterpolator::step(double dt, const JointState& arm) {
  since_command_ += dt;
  if (since_command_ > command_timeout_) stop(arm);
  if (mode_ == DriveMode::kTracking) {
    track();
  } else {
    brake(dt);
  }
  return reference_;
}

void SetPointInterpolator::track() {
  const JointVector acceleration = (target_.qd - from_qd_) / period_;
  const double ahead = since_command_ - period_;  // < 0: the set-point is not due yet
  reference_ = target_;
  if (ahead < 0.0) {
    reference_.q += target_.qd * ahead + 0.5 * acceleration * ahead * ahead;
    reference_.qd += acceleration * ahead;
  } else if (const double stop = stop_time(limits_, target_.qd); stop > 0.0) {
    const double braked = std::min(ahead, stop);
    reference_.q += target_.qd * braked * (1.0 - 0.5 * braked / stop);
    reference_.qd *= 1.0 - braked / stop;
  }
}

void SetPointInterpolator::brake(double dt) {
  advance_within_limits(limits_, braking_velocity(limits_, reference_.qd, dt), dt, reference_);
  if (!reference_.qd.isZero()) return;  // up to rounding
  reference_.qd.setZero();
  mode_ = DriveMode::kIdle;
}

}  // namespace hecaton::planner
