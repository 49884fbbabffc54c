#include "services/arm_driver/devices/ros2_control/velocity_commands.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::device::ros2_control {
namespace {

/// The largest correction, as a share of the velocity limit, when the hardware executes each velocity in full.
constexpr double kCorrection = 0.25;
/// Time constant with which the feed-forward makes up for what it has missed: that of a few control periods [s].
constexpr double kMakesUp = 0.03;
/// With a shorter lag the gain does not grow any more: states and commands take some time on the network [s].
constexpr double kShortestDelay = 0.05;
/// Times the acceleration limits: the arm must be able to catch up.
constexpr double kAcceleration = 2.0;
/// A longer step between two velocities allows no larger change [s].
constexpr double kLongestStep = 0.1;
constexpr double kLongestBraking = 0.05;  // the same of a stop [s]
/// An arm that the largest correction does not bring nearer, by this factor in this time, is lost. One that has gone on
/// while this process stalled comes nearer.
constexpr double kNearer = 0.95;
constexpr std::chrono::milliseconds kLost{200};

/// An arm that is measured this late is corrected by the oldest set-point.
constexpr std::chrono::seconds kKept{1};

double seconds(Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

double gain(double tracking_delay) {
  return 0.25 / std::max(kShortestDelay, tracking_delay);
}

}  // namespace

VelocityCommands::VelocityCommands(JointLimits limits, double tracking_delay)
    : limits_(std::move(limits)),
      delay_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(tracking_delay))),
      gain_(gain(tracking_delay)) {}

void VelocityCommands::begin(const JointVector& q, Clock::time_point now) {
  velocity_ = JointVector::Zero(q.size());
  forward_velocity_ = velocity_;
  forward_ = q;
  sent_at_ = now;
  set_points_.assign(1, {now, q});
  far_.reset();
  lost_.reset();
}

const JointVector& VelocityCommands::follow(const JointState& set_point, Clock::time_point due,
                                            const MeasuredPosition& measured, double speed_scaling,
                                            Clock::time_point now) {
  set_points_.push_back({due, set_point.q});
  const JointVector error = set_point_at(measured.at - delay_) - measured.q;
  const double share = kCorrection + 1.0 - speed_scaling;
  note(error, share, now);
  const JointVector most = limits_.velocity * share;
  const JointVector correction = (error * gain_).cwiseMax(-most).cwiseMin(most);
  integrate(now);
  const JointVector missed = set_point.q - set_point.qd * seconds(due - now) - forward_;
  const JointVector makes_up = limits_.velocity * kCorrection;
  forward_velocity_ = set_point.qd + (missed / kMakesUp).cwiseMax(-makes_up).cwiseMin(makes_up);
  forward_velocity_ = forward_velocity_.cwiseMax(-limits_.velocity).cwiseMin(limits_.velocity);
  JointVector next = forward_velocity_ + correction;
  next = next.cwiseMax(-limits_.velocity).cwiseMin(limits_.velocity);
  const JointVector change =
      limits_.acceleration * (kAcceleration * std::clamp(seconds(now - sent_at_), 0.0, kLongestStep));
  next = next.cwiseMax(velocity_ - change).cwiseMin(velocity_ + change);
  for (Eigen::Index joint = 0; joint < next.size(); ++joint) {
    const double twice = 2.0 * limits_.acceleration[joint];
    const double up = std::sqrt(twice * std::max(0.0, limits_.upper[joint] - measured.q[joint]));
    const double down = std::sqrt(twice * std::max(0.0, measured.q[joint] - limits_.lower[joint]));
    next[joint] = std::clamp(next[joint], -down, up);
  }
  velocity_ = next;
  sent_at_ = now;
  return velocity_;
}

void VelocityCommands::integrate(Clock::time_point now) {
  forward_ += forward_velocity_ * seconds(now - sent_at_);
}

const JointVector& VelocityCommands::brake(Clock::time_point now) {
  integrate(now);
  velocity_ = planner::braking_velocity(limits_, velocity_, std::min(kLongestBraking, seconds(now - sent_at_)));
  forward_velocity_ = velocity_;
  sent_at_ = now;
  return velocity_;
}

// Linear between two set-points. Those that are older than `at`, but for one, are not needed any more, because the
// instants of measurements grow.
JointVector VelocityCommands::set_point_at(Clock::time_point at) const {
  const auto after =
      std::find_if(set_points_.begin(), set_points_.end(), [&](const Sample& sample) { return sample.at >= at; });
  if (after == set_points_.begin()) return after->q;
  if (after == set_points_.end()) return set_points_.back().q;
  const auto before = std::prev(after);
  const double part = seconds(at - before->at) / seconds(after->at - before->at);
  return before->q + part * (after->q - before->q);
}

void VelocityCommands::note(const JointVector& error, double share, Clock::time_point now) {
  while (set_points_.size() > 2 && now - set_points_[1].at > delay_ + kKept) set_points_.pop_front();
  const JointVector limit = limits_.velocity * (share / gain_);
  Eigen::Index joint = 0;
  const double worst = (error.cwiseAbs().array() / limit.array()).maxCoeff(&joint);
  if (worst <= 1.0) {
    far_.reset();
    return;
  }
  if (!far_ || worst < kNearer * far_->error) far_ = {worst, now};
  if (!lost_ && now - far_->since >= kLost) lost_ = LostJoint{joint, std::abs(error[joint]), limit[joint]};
}

double VelocityCommands::delay(double tracking_delay, double speed_scaling) {
  return tracking_delay + (1.0 / speed_scaling - 1.0) / gain(tracking_delay);
}

}  // namespace hecaton::device::ros2_control
