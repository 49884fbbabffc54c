#include "planner/simulation/servo.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Rounding must not delay a set-point by a period [s].
constexpr double kTimeTolerance = 1e-9;
/// Controllers derive velocities from positions over some 20 ms: noise of a velocity per noise of a position [1/s].
constexpr double kVelocityNoise = 50.0;
/// Rate at which a position error is corrected [1/s].
constexpr double kTrackingGain = 30.0;
/// Share of the acceleration limit for the end of a correction; prevents overshoot.
constexpr double kCorrectionShare = 0.5;

/// Velocity that reduces a position error [rad/s | m/s].
JointVector correction(const JointLimits& limits, const JointVector& error) {
  const JointVector linear = kTrackingGain * error;
  const JointVector fastest = (2.0 * kCorrectionShare * limits.acceleration.cwiseProduct(error.cwiseAbs())).cwiseSqrt();
  return linear.cwiseMax(-fastest).cwiseMin(fastest);
}

}  // namespace

// Commands the set-point's velocity plus a correction of the error expected at the end of the step.
void follow_within_limits(const JointLimits& limits, const JointState& set_point, double dt, JointState& state) {
  const JointVector error = set_point.q - (state.q + 0.5 * (state.qd + set_point.qd) * dt);
  advance_within_limits(limits, set_point.qd + correction(limits, error), dt, state);
}

// From the documents of the interfaces and their defaults, which the pages of the devices name. None was measured at a
// real robot. UR: cycles of 8 ms and 2 ms, lookahead_time of servoj 0.03 s. ABB: cycles of 4 ms, low-pass filter of 20
// Hz, servo. ros2_control: cycles of 4 ms, `lookahead` of a trajectory 0.1 s, servo.
const std::vector<ServoPreset>& servo_presets() {
  static const std::vector<ServoPreset> presets{
      {"ur_cb3",
       {.period = 0.008, .dead_time = 0.012, .jitter = 0.004, .lag = 0.03, .noise = 1e-4, .resolution = 5e-5}},
      {"ur_e_series",
       {.period = 0.002, .dead_time = 0.004, .jitter = 0.002, .lag = 0.03, .noise = 5e-5, .resolution = 2e-5}},
      {"abb_egm",
       {.period = 0.004,
        .dead_time = 0.016,
        .jitter = 0.004,
        .lag = 0.034,
        .damping = 0.8,
        .noise = 2e-5,
        .resolution = 2e-5}},
      {"ros2_control",
       {.period = 0.004, .dead_time = 0.1, .jitter = 0.01, .lag = 0.05, .noise = 1e-4, .resolution = 1e-4}},
  };
  return presets;
}

Servo::Servo(JointLimits limits, const ServoParameters& parameters, const JointVector& q, std::uint64_t seed)
    : limits_(std::move(limits)),
      parameters_(parameters),
      state_{q, JointVector::Zero(q.size())},
      active_{0.0, 0.0, state_},
      random_(seed) {
  measure();
}

void Servo::follow(const JointState& set_point, double dt) {
  now_ += dt;
  const double wait = parameters_.dead_time + parameters_.jitter * random_.uniform(-1.0, 1.0);
  const double earliest = pending_.empty() ? 0.0 : pending_.back().due;
  pending_.push_back({std::max(earliest, now_ + wait), now_ + parameters_.dead_time, set_point});
  take();
  // Between its cycles, and until a late set-point arrives, the controller goes on at the velocity of the last one.
  // What stands during a step is the target in its middle.
  const double at = now_ - (parameters_.lag > 0.0 ? 0.5 * dt : 0.0);
  approach({active_.target.q + active_.target.qd * (at - active_.at), active_.target.qd}, dt);
  measure();
}

/// In each of its cycles the controller takes the newest set-point that has arrived.
void Servo::take() {
  if (now_ < next_cycle_ - kTimeTolerance) return;
  next_cycle_ = std::max(next_cycle_ + parameters_.period, now_);
  while (!pending_.empty() && pending_.front().due <= now_ + kTimeTolerance) {
    active_ = std::move(pending_.front());
    pending_.pop_front();
  }
}

// Without a lag as a perfect controller does, because a set-point may come late and then jump. Else:
// First order:   q̇ = (q_target − q)/L
// Second order:  q̈ = ω² (q_target − q) − 2 ζ ω q̇,   ω = 2 ζ/L
// Both are behind a ramp by L. Solved exactly for a target that stands during dt.
void Servo::approach(const JointState& target, double dt) {
  const double L = parameters_.lag;
  if (L <= 0.0) return follow_within_limits(limits_, target, dt, state_);
  const JointVector before = state_.q;
  if (parameters_.damping <= 0.0) {
    state_.q += (target.q - state_.q) * (1.0 - std::exp(-dt / L));
  } else {
    const double decay = 2.0 * parameters_.damping * parameters_.damping / L;  // ζ ω
    const double omega = 2.0 * parameters_.damping / L;
    const double damped = omega * std::sqrt(1.0 - parameters_.damping * parameters_.damping);
    const JointVector x = state_.q - target.q;
    const JointVector b = (state_.qd + decay * x) / damped;
    const double fading = std::exp(-decay * dt);
    const double c = std::cos(damped * dt);
    const double s = std::sin(damped * dt);
    state_.q = target.q + fading * (c * x + s * b);
    state_.qd = fading * ((damped * b - decay * x) * c - (damped * x + decay * b) * s);
  }
  state_.q = state_.q.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  if (parameters_.damping <= 0.0) state_.qd = (state_.q - before) / dt;
}

void Servo::brake(double dt) {
  now_ += dt;
  advance_within_limits(limits_, braking_velocity(limits_, state_.qd, dt), dt, state_);
  if (state_.qd.isZero()) state_.qd.setZero();  // up to rounding
  pending_.clear();
  active_ = {now_, now_, {state_.q, JointVector::Zero(state_.q.size())}};
  measure();
}

void Servo::measure() {
  measured_ = state_;
  const double step = parameters_.resolution;
  for (Eigen::Index j = 0; j < measured_.q.size(); ++j) {
    if (parameters_.noise > 0.0) {
      measured_.q[j] += parameters_.noise * std::clamp(random_.normal(), -3.0, 3.0);
      measured_.qd[j] += kVelocityNoise * parameters_.noise * std::clamp(random_.normal(), -3.0, 3.0);
    }
    if (step > 0.0) measured_.q[j] = step * std::round(measured_.q[j] / step);
    measured_.q[j] = std::clamp(measured_.q[j], limits_.lower[j], limits_.upper[j]);
  }
}

}  // namespace hecaton::planner
