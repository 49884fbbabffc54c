#include "services/arm_driver/device_probe.hpp"

#include <algorithm>
#include <utility>

namespace hecaton::services {

using device::DeviceMode;
using device::DeviceResult;
using device::DeviceState;

namespace {
/// Set-points are kept for this time: a state may be as old.
constexpr std::chrono::seconds kKept{2};
}  // namespace

DeviceProbe::DeviceProbe(device::ArmDevice& device, Eigen::Index joints, std::chrono::nanoseconds period, Now now)
    : device_(device), joints_(joints), period_(period), now_(std::move(now)) {}

DeviceResult DeviceProbe::configure() {
  return checked(device_.configure(), "configure");
}

DeviceResult DeviceProbe::activate() {
  before_activation_ = measured_.q;
  active_ = true;
  ++activations_;
  set_points_.clear();
  return checked(device_.activate(), "activate");
}

DeviceState DeviceProbe::read(Clock::time_point now) {
  read_at_ = now;
  const auto began = now_();
  state_ = device_.read(now);
  read_took_ = now_() - began;
  check(state_);
  if (state_.measured.q.size() != joints_) return state_;
  measured_ = state_.measured;
  measured_at_ = now - state_.age;
  if (state_.mode == DeviceMode::kReady) oldest_ = std::max(oldest_, state_.age);
  note_jump(state_.measured.q);
  return state_;
}

DeviceResult DeviceProbe::write(const device::JointState& set_point, std::chrono::nanoseconds valid_for) {
  note_jump(set_point.q);
  while (!set_points_.empty() && set_points_.front().due < read_at_ - kKept) set_points_.pop_front();
  set_points_.push_back({read_at_, read_at_ + period_, read_at_ + valid_for, set_point.q});
  const auto began = now_();
  DeviceResult result = device_.write(set_point, valid_for);
  if (read_took_) durations_.push_back(*std::exchange(read_took_, std::nullopt) + (now_() - began));
  return checked(std::move(result), "write");
}

void DeviceProbe::stop(std::string_view reason) {
  active_ = false;
  before_activation_.reset();
  device_.stop(reason);
}

void DeviceProbe::deactivate() {
  active_ = false;
  before_activation_.reset();
  device_.deactivate();
}

std::optional<device::JointVector> DeviceProbe::wanted() const {
  const auto later = std::find_if(set_points_.begin(), set_points_.end(),
                                  [&](const SetPoint& one) { return one.written >= measured_at_; });
  if (later == set_points_.begin() || std::prev(later)->valid_until < measured_at_) return std::nullopt;
  const auto after = std::find_if(set_points_.begin(), set_points_.end(),
                                  [&](const SetPoint& one) { return one.due >= measured_at_; });
  if (after == set_points_.begin()) return after->q;
  const auto before = std::prev(after);
  if (after == set_points_.end()) return before->q;
  const std::chrono::duration<double> passed = measured_at_ - before->due;
  const std::chrono::duration<double> apart = after->due - before->due;
  return before->q + (after->q - before->q) * (passed / apart);
}

bool DeviceProbe::ready() const {
  return state_.mode == DeviceMode::kReady && state_.measured.q.size() == joints_ && state_.measured.q.allFinite();
}

DeviceResult DeviceProbe::checked(DeviceResult result, std::string_view call) {
  if (result && result->text.empty() && violation_.empty()) violation_ = std::string(call) + " fails without a text";
  return result;
}

void DeviceProbe::check(const DeviceState& state) {
  if (!violation_.empty()) return;
  const auto& [q, qd] = state.measured;
  if (state.mode != DeviceMode::kReady && state.text.empty()) {
    violation_ = "a state that is not ready has no text";
  } else if (q.size() > 0 && (q.size() != joints_ || qd.size() != joints_)) {
    violation_ = std::to_string(q.size()) + " positions and " + std::to_string(qd.size()) + " velocities";
  } else if (!q.allFinite() || !qd.allFinite()) {
    violation_ = "a measured value is not finite";
  } else if (state.age < std::chrono::nanoseconds(0)) {
    violation_ = "a state is from the future";
  } else if (!(state.speed_scaling >= 0.0 && state.speed_scaling <= 1.0)) {
    violation_ = "speed_scaling = " + std::to_string(state.speed_scaling) + " is not from 0 to 1";
  }
}

void DeviceProbe::note_jump(const device::JointVector& q) {
  if (!before_activation_ || before_activation_->size() != q.size()) return;
  jump_ = std::max(jump_, (q - *before_activation_).cwiseAbs().maxCoeff());
}

}  // namespace hecaton::services
