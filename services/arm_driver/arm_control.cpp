#include "services/arm_driver/arm_control.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace hecaton::services {
namespace {

using device::DeviceMode;
using msg::CauseKind;

/// Delay before a failed device is configured again.
constexpr std::chrono::seconds kRetry{1};
/// After a longer stall the stop profile is over anyway.
constexpr int kMostPeriodsAtOnce = 500;
/// A joint that moves faster than this is not at rest [rad/s | m/s].
constexpr double kMoving = 1e-3;

/// Names the joint that is farthest from its set-point.
std::string far_text(const planner::JointVector& commanded, const planner::JointVector& measured) {
  Eigen::Index joint = 0;
  (commanded - measured).cwiseAbs().maxCoeff(&joint);
  char text[128];
  std::snprintf(text, sizeof text, "the set-point is too far from the arm: joint %d measured at %.3f, set-point %.3f",
                static_cast<int>(joint) + 1, measured[joint], commanded[joint]);
  return text;
}

std::string milliseconds_text(const char* format, double seconds) {
  char text[96];
  std::snprintf(text, sizeof text, format, seconds * 1e3);
  return text;
}

}  // namespace

ArmControl::ArmControl(ArmControlSetup setup, device::ArmDevice& device)
    : setup_(std::move(setup)),
      device_(device),
      gate_(static_cast<int>(setup_.limits.lower.size())),
      interpolator_(setup_.limits, planner::JointVector::Zero(setup_.limits.lower.size()), setup_.command_timeout),
      hold_(make_cause(CauseKind::CAUSE_MODE_UNKNOWN, setup_.arm, "no cell mode received yet")) {}

ArmControl::~ArmControl() {
  device_.stop("the driver shuts down");
  device_.deactivate();
}

void ArmControl::read(Clock::time_point now) {
  if (now_ == Clock::time_point()) accepted_at_ = retry_at_ = measured_at_ = now;
  const bool stalled = now - now_ > setup_.valid_for;
  now_ = now;
  if (!configured()) return;
  state_ = device_.read(now);
  if (state_.measured.q.size() > 0) measured_at_ = now - state_.age;
  if (const auto reason = unusable_state()) return fail(*reason);
  const bool ready = state_.mode == DeviceMode::kReady;
  if (phase_ == Phase::kActive && !ready) release();
  if (stalled) stop(state_.measured);  // the device has begun its own stop meanwhile
  if (phase_ != Phase::kInactive || !ready) return;
  if (const auto failure = device_.activate()) return fail(failure->text);
  phase_ = Phase::kActive;
  interpolator_.reset(state_.measured.q);
  reference_at_ = now;
}

bool ArmControl::configured() {
  if (phase_ != Phase::kUnconfigured) return true;
  if (now_ < retry_at_) return false;
  if (const auto failure = device_.configure()) {
    fail(failure->text);
    return false;
  }
  phase_ = Phase::kInactive;
  return true;
}

// Why the arm must not be moved on this state; empty when it may be.
std::optional<std::string> ArmControl::unusable_state() const {
  if (state_.mode == DeviceMode::kFailed) return state_.text;
  const auto joints = setup_.limits.lower.size();
  const auto& [q, qd] = state_.measured;
  if (state_.mode != DeviceMode::kReady && q.size() == 0) return std::nullopt;
  if (q.size() != joints || qd.size() != joints) {
    return "the device measures " + std::to_string(q.size()) + " positions and " + std::to_string(qd.size()) +
           " velocities, but the arm has " + std::to_string(joints) + " joints";
  }
  if (!q.allFinite() || !qd.allFinite()) return "the device measures a value that is not finite";
  const std::chrono::duration<double> age = state_.age;
  if (state_.mode != DeviceMode::kReady || age.count() <= setup_.command_timeout) return std::nullopt;
  return milliseconds_text("the device's state is %.0f ms old", age.count()) +
         milliseconds_text(" (limit %.0f ms, timing.command_timeout)", setup_.command_timeout);
}

void ArmControl::fail(const std::string& text) {
  device_.stop(text);
  release();
  phase_ = Phase::kUnconfigured;
  retry_at_ = now_ + kRetry;
  state_.mode = DeviceMode::kFailed;
  state_.text = text;
  const auto joints = setup_.limits.lower.size();
  if (state_.measured.q.size() != joints || state_.measured.qd.size() != joints) state_.measured = {};
}

void ArmControl::release() {
  device_.deactivate();
  phase_ = Phase::kInactive;
  interpolator_.reset(interpolator_.reference().q);
}

void ArmControl::stop(const planner::JointState& from) {
  if (interpolator_.mode() != planner::DriveMode::kTracking) return;
  interpolator_.stop(from);
  reference_at_ = now_;
}

void ArmControl::set_hold(std::optional<msg::Cause> hold) {
  hold_ = std::move(hold);
  if (hold_) stop(continues_from());
}

// A device that lags behind continues from its last set-point, see ArmDevice::tracking_delay().
const planner::JointState& ArmControl::continues_from() const {
  return device_.tracking_delay() > 0.0 ? interpolator_.reference() : state_.measured;
}

// A command counts as accepted also while the arm is held, so that its planner knows that the driver receives it.
Judgement ArmControl::command(const msg::ArmCommand& command) {
  Judgement judgement = gate_.judge(command);
  if (judgement.verdict == Verdict::kRepeated) return judgement;
  const auto& set_point = gate_.set_point();
  const bool follows = !hold_ && phase_ == Phase::kActive;
  if (judgement.verdict == Verdict::kAccepted && follows) {
    const bool near = interpolator_.command(set_point, continues_from());
    reference_at_ = now_;
    if (!near) {
      judgement = {Verdict::kTooFar, make_cause(CauseKind::CAUSE_COMMAND_TOO_FAR, command.node(),
                                                far_text(set_point.target.q, state_.measured.q))};
    }
  }
  refusal_.reset();
  if (judgement.verdict == Verdict::kAccepted) {
    commanded_ = true;
    accepted_at_ = now_;
  } else {
    refusal_ = judgement.cause;
  }
  return judgement;
}

void ArmControl::write() {
  if (phase_ == Phase::kActive) {
    interpolate();
    if (const auto failure = device_.write(interpolator_.reference(), setup_.valid_for)) fail(failure->text);
  }
  ran_ = ran_ || interpolator_.mode() == planner::DriveMode::kTracking;
}

// Steps of at most a period make a stop within one step end at the right position.
void ArmControl::interpolate() {
  const Clock::time_point due = now_ + setup_.period;
  reference_at_ = std::max(reference_at_, due - kMostPeriodsAtOnce * setup_.period);
  while (reference_at_ < due) {
    const auto next = std::min(due, reference_at_ + setup_.period);
    (void)interpolator_.step(std::chrono::duration<double>(next - reference_at_).count(), continues_from());
    reference_at_ = next;
  }
}

msg::ArmMode ArmControl::mode() const {
  if (state_.mode == DeviceMode::kFailed) return msg::ArmMode::ARM_FAILED;
  if (interpolator_.mode() == planner::DriveMode::kTracking) return msg::ArmMode::ARM_RUNNING;
  if (interpolator_.mode() == planner::DriveMode::kStopping) return msg::ArmMode::ARM_BRAKING;
  const auto& qd = state_.measured.qd;
  // A device may lag behind the end of the stop profile: the arm has stopped when its measured joints have.
  if ((ran_ || phase_ != Phase::kActive) && qd.size() > 0 && qd.cwiseAbs().maxCoeff() > kMoving)
    return msg::ArmMode::ARM_BRAKING;
  return ran_ ? msg::ArmMode::ARM_STOPPED : msg::ArmMode::ARM_STARTING;
}

msg::Cause ArmControl::cause() const {
  if (mode() == msg::ArmMode::ARM_RUNNING) return {};
  switch (state_.mode) {
    case DeviceMode::kFailed:
      return make_cause(CauseKind::CAUSE_DEVICE_FAILED, setup_.arm, state_.text);
    case DeviceMode::kEmergencyStop:
      return make_cause(CauseKind::CAUSE_EMERGENCY_STOP, setup_.arm, state_.text);
    case DeviceMode::kProtectiveStop:
      return make_cause(CauseKind::CAUSE_PROTECTIVE_STOP, setup_.arm, state_.text);
    case DeviceMode::kNotReady:
      return make_cause(CauseKind::CAUSE_DEVICE_NOT_READY, setup_.arm, state_.text);
    case DeviceMode::kReady:
      break;
  }
  if (hold_) return *hold_;
  if (refusal_) return *refusal_;
  if (!commanded_) return make_cause(CauseKind::CAUSE_STARTING, setup_.arm, "no command received yet");
  if (command_age() > setup_.command_timeout) {
    return make_cause(CauseKind::CAUSE_COMMANDS_CEASED, setup_.arm,
                      milliseconds_text("commands ceased: none for more than %.0f ms", setup_.command_timeout));
  }
  return make_cause(CauseKind::CAUSE_STARTING, setup_.arm, "starts to follow commands");
}

}  // namespace hecaton::services
