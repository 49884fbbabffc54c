#include "services/arm_driver/device_session.hpp"

#include <cstdio>
#include <utility>

namespace hecaton::services {
namespace {

using device::DeviceMode;
using msg::CauseKind;

/// Delay before a failed device is configured again.
constexpr std::chrono::seconds kRetry{1};
// Longer than a supervisor needs to hear of a stop, also on a loaded machine.
constexpr std::chrono::seconds kStopShown{1};

std::string age_text(double age, double limit) {
  char text[192];
  std::snprintf(text, sizeof text,
                "the device's state is %.0f ms old (limit %.0f ms, timing.command_timeout): is a cable out, or has its "
                "controller or program stopped?",
                age * 1e3, limit * 1e3);
  return text;
}

/// `failure` and what a person does about an arm that is held since then. A device may have said it itself.
std::string with_resume(const std::string& failure, const std::string& arm) {
  const std::string order = "'hecaton resume " + arm + "'";
  if (failure.find(order) != std::string::npos) return failure;
  const std::string start = failure.ends_with('?') ? " Once" : "; once";
  return failure + start + " it works again, call " + order;
}

/// CAUSE_NONE: a device in this mode works.
CauseKind kind_of(DeviceMode mode) {
  switch (mode) {
    case DeviceMode::kReady:
      return CauseKind::CAUSE_NONE;
    case DeviceMode::kStarting:
      return CauseKind::CAUSE_STARTING;
    case DeviceMode::kNotReady:
      return CauseKind::CAUSE_DEVICE_NOT_READY;
    case DeviceMode::kRemoteControlOff:
      return CauseKind::CAUSE_REMOTE_CONTROL_OFF;
    case DeviceMode::kProgramStopped:
      return CauseKind::CAUSE_PROGRAM_STOPPED;
    case DeviceMode::kSafeguardStop:
      return CauseKind::CAUSE_SAFEGUARD_STOP;
    case DeviceMode::kProtectiveStop:
      return CauseKind::CAUSE_PROTECTIVE_STOP;
    case DeviceMode::kEmergencyStop:
      return CauseKind::CAUSE_EMERGENCY_STOP;
    case DeviceMode::kFailed:
      return CauseKind::CAUSE_DEVICE_FAILED;
  }
  return CauseKind::CAUSE_DEVICE_FAILED;
}

}  // namespace

msg::Cause observed_cause(const std::string& arm) {
  return make_cause(CauseKind::CAUSE_OBSERVED, arm,
                    "others move it; 'hecaton device " + arm + " command' gives it back to its planner");
}

DeviceSession::DeviceSession(DeviceSessionSetup setup, device::ArmDevice& device, std::optional<msg::Cause> latched)
    : setup_(std::move(setup)), device_(device), latched_(std::move(latched)) {}

DeviceSession::~DeviceSession() {
  device_.stop("the driver shuts down");
  device_.deactivate();
}

void DeviceSession::read(Clock::time_point now, bool may_move) {
  if (now_ == Clock::time_point()) retry_at_ = measured_at_ = now;
  now_ = now;
  if (!configured()) return go_on_stopping();
  take(device_.read(now));
  if (const auto reason = unusable_state()) return fail(*reason);
  const bool ready = state_.mode == DeviceMode::kReady;
  if (state_.mode != DeviceMode::kStarting) failure_.reset();
  const bool awaited = phase_ == Phase::kActivating && state_.mode == DeviceMode::kStarting;
  if (phase_ == Phase::kInactive && ready && may_move && !latched_ && !observed_) {
    if (const auto failure = device_.activate()) return fail(failure->text);
    phase_ = Phase::kActivating;
    take(device_.read(now));
    if (const auto reason = unusable_state()) return fail(*reason);
    if (state_.mode == DeviceMode::kReady) follow();
  } else if (phase_ == Phase::kActivating && ready) {
    follow();
  } else if (phase_ != Phase::kInactive && !ready && !awaited) {
    leave();
  }
}

// A device that measures nothing now leaves the last measurement in force, with its age.
void DeviceSession::take(device::DeviceState state) {
  if (state.measured.q.size() > 0) {
    measured_at_ = now_ - state.age;
  } else if (state.mode != DeviceMode::kReady) {
    state.measured = std::move(state_.measured);
  }
  state_ = std::move(state);
}

void DeviceSession::set_observed(bool observed) {
  observed_ = observed;
  if (phase_ == Phase::kActive || phase_ == Phase::kActivating) {
    device_.deactivate();
    phase_ = Phase::kInactive;
  }
  latched_.reset();
  must_be_resumed_ = false;
}

void DeviceSession::write(const device::JointState& set_point, std::chrono::nanoseconds valid_for) {
  if (!set_point.q.allFinite() || !set_point.qd.allFinite()) return fail("the driver's set-point is not finite");
  if (const auto failure = device_.write(set_point, valid_for)) fail(failure->text);
}

bool DeviceSession::configured() {
  if (phase_ != Phase::kUnconfigured) return true;
  if (now_ < retry_at_) return false;
  if (const auto failure = device_.configure()) {
    stops_ = false;
    fail(failure->text);
    return false;
  }
  phase_ = Phase::kInactive;
  return true;
}

// A device may brake its arm in read(). Its errors are known already; other arms avoid this one by what it measures.
void DeviceSession::go_on_stopping() {
  if (!stops_) return;
  device::DeviceState state = device_.read(now_);
  const auto& [q, qd] = state.measured;
  if (q.size() != setup_.joints || qd.size() != setup_.joints || !q.allFinite() || !qd.allFinite()) return;
  measured_at_ = now_ - state.age;
  state_.measured = std::move(state.measured);
}

// Why the arm must not be moved on this state; empty when it may be.
std::optional<std::string> DeviceSession::unusable_state() const {
  if (state_.mode == DeviceMode::kFailed) return state_.text;
  const auto& [q, qd] = state_.measured;
  if (state_.mode != DeviceMode::kReady && q.size() == 0) return std::nullopt;
  if (q.size() != setup_.joints || qd.size() != setup_.joints) {
    return "the device measures " + std::to_string(q.size()) + " positions and " + std::to_string(qd.size()) +
           " velocities, but the arm has " + std::to_string(setup_.joints) + " joints";
  }
  if (!q.allFinite() || !qd.allFinite()) return "the device measures a value that is not finite";
  // Other arms avoid an observed arm by its state, whatever its mode is.
  const bool must_be_fresh = state_.mode == DeviceMode::kReady || (observed_ && state_.mode != DeviceMode::kStarting);
  const std::chrono::duration<double> age = now_ - measured_at_;
  if (!must_be_fresh || age.count() <= setup_.state_age_limit) return std::nullopt;
  return age_text(age.count(), setup_.state_age_limit);
}

void DeviceSession::fail(const std::string& text) {
  must_be_resumed_ = must_be_resumed_ || phase_ == Phase::kActive || phase_ == Phase::kActivating;
  stops_ = stops_ || phase_ != Phase::kUnconfigured;
  device_.stop(text);
  state_.mode = DeviceMode::kFailed;
  state_.text = must_be_resumed_ ? with_resume(text, setup_.arm) : text;
  failure_ = state_.text;
  leave();
  phase_ = Phase::kUnconfigured;
  retry_at_ = now_ + kRetry;
  if (state_.measured.q.size() != setup_.joints || state_.measured.qd.size() != setup_.joints) state_.measured = {};
}

void DeviceSession::follow() {
  phase_ = Phase::kActive;
  must_be_resumed_ = false;
}

void DeviceSession::leave() {
  device_.deactivate();
  if (phase_ == Phase::kActive || phase_ == Phase::kActivating) {
    must_be_resumed_ = true;
    latched_ = cause_of_state();
    // The supervisor does not hold an arm for a device that starts, so that no resume would end the latch.
    if (latched_->kind() == CauseKind::CAUSE_STARTING) {
      latched_ = make_cause(
          CauseKind::CAUSE_PROGRAM_STOPPED, setup_.arm,
          with_resume("the device follows no set-points any more and starts again: " + state_.text, setup_.arm));
    }
    latched_at_ = now_;
  }
  phase_ = Phase::kInactive;
}

msg::Cause DeviceSession::cause_of_state() const {
  const CauseKind kind = kind_of(state_.mode);
  return kind == CauseKind::CAUSE_NONE ? msg::Cause() : make_cause(kind, setup_.arm, state_.text);
}

// While a device that has failed connects again, its failure is still the reason. A device that was stopped may say one
// sample later only that it is not ready: why it stopped stays the reason for kStopShown, so that the supervisor sees
// it.
msg::Cause DeviceSession::cause() const {
  if (failure_) return make_cause(CauseKind::CAUSE_DEVICE_FAILED, setup_.arm, *failure_);
  msg::Cause present = cause_of_state();
  if (observed_ && state_.measured.q.size() > 0) {
    return observed_cause(setup_.arm);
  }
  const bool hides_a_stop = present.kind() == CauseKind::CAUSE_DEVICE_NOT_READY && now_ - latched_at_ < kStopShown;
  const bool is_stop = !is_none(present) && present.kind() != CauseKind::CAUSE_STARTING && !hides_a_stop;
  if (is_stop || !latched_) return present;
  return *latched_;
}

}  // namespace hecaton::services
