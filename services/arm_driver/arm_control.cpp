#include "services/arm_driver/arm_control.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace hecaton::services {
namespace {

using msg::CauseKind;

/// After a longer stall the stop profile is over anyway.
constexpr int kMostPeriodsAtOnce = 500;
/// A joint that moves faster than this is not at rest [rad/s | m/s].
constexpr double kMoving = 1e-3;
/// Measured velocities of real arms at rest are noisy: their mean over some time must be above this, too [rad/s | m/s].
constexpr double kMovingOnAverage = 3e-3;
constexpr double kAveraged = 0.05;  // time constant of that mean [s]

/// Names the joint that is farthest from its set-point.
std::string far_text(const planner::JointVector& commanded, const planner::JointVector& measured) {
  Eigen::Index joint = 0;
  (commanded - measured).cwiseAbs().maxCoeff(&joint);
  char text[128];
  std::snprintf(text, sizeof text, "the set-point is too far from the arm: joint %d measured at %.3f, set-point %.3f",
                static_cast<int>(joint) + 1, measured[joint], commanded[joint]);
  return text;
}

CommandLimits command_limits(const ArmControlSetup& setup) {
  const std::chrono::duration<double> timeout(setup.command_timeout);
  return {setup.command_timeout, std::chrono::duration_cast<std::chrono::nanoseconds>(timeout)};
}

std::string milliseconds_text(const char* format, double seconds) {
  char text[96];
  std::snprintf(text, sizeof text, format, seconds * 1e3);
  return text;
}

}  // namespace

ArmControl::ArmControl(const ArmControlSetup& setup, device::ArmDevice& device)
    : setup_(setup),
      session_({setup.arm, setup.limits.lower.size(), setup.command_timeout}, device, setup.latched),
      gate_(static_cast<int>(setup.limits.lower.size()), command_limits(setup)),
      interpolator_(setup.limits, planner::JointVector::Zero(setup.limits.lower.size()), setup.command_timeout),
      hold_(make_cause(CauseKind::CAUSE_MODE_UNKNOWN, setup.arm, "no cell mode received yet")) {
  set_observed(setup.observed);
}

void ArmControl::read(Clock::time_point now) {
  if (now_ == Clock::time_point()) accepted_at_ = now;
  const bool stalled = now - now_ > setup_.valid_for;
  const bool was_active = session_.active();
  const double dt = std::chrono::duration<double>(now - now_).count();
  now_ = now;
  session_.read(now, !hold_ && !observed_);
  average_velocity(dt);
  if (was_active && !session_.active()) {
    interpolator_.reset(interpolator_.reference().q);
  } else if (!was_active && session_.active()) {
    interpolator_.reset(measured().q);
    written_ = interpolator_.reference();
    reference_at_ = now;
  } else if (session_.active() && stalled) {
    stop(continues_from());  // the device has begun its own stop meanwhile
  }
}

void ArmControl::average_velocity(double dt) {
  const planner::JointVector& qd = measured().qd;
  if (mean_qd_.size() != qd.size()) mean_qd_ = planner::JointVector::Zero(qd.size());
  if (!qd.allFinite()) return;
  mean_qd_ += (qd - mean_qd_) * std::min(1.0, dt / kAveraged);
}

void ArmControl::stop(const planner::JointState& from) {
  if (interpolator_.mode() != planner::DriveMode::kTracking) return;
  interpolator_.stop(from);
  reference_at_ = now_;
}

void ArmControl::set_hold(std::optional<msg::Cause> hold, bool for_device) {
  hold_ = std::move(hold);
  if (hold_ && for_device) session_.release();
  if (hold_) stop(continues_from());
}

void ArmControl::set_observed(bool observed) {
  if (observed == observed_) return;
  observed_ = observed;
  if (!observed) {
    session_.set_observed(false);
  } else if (session_.active()) {
    stop(continues_from());
  }
  leave_to_others();
}

// The device follows the driver's stop profile to its end.
void ArmControl::leave_to_others() {
  const bool stops = interpolator_.mode() != planner::DriveMode::kIdle;
  if (!observed_ || session_.observed() || (session_.active() && stops)) return;
  session_.set_observed(true);
  ran_ = false;
}

// A device that lags behind continues from its last set-point, see ArmDevice::tracking_delay().
const planner::JointState& ArmControl::continues_from() const {
  return tracking_delay() > 0.0 ? interpolator_.reference() : measured();
}

// A set-point that a lagging device cannot have come near to. The interpolator compares with the last set-point only.
bool ArmControl::is_far(const planner::TimedSetPoint& set_point) const {
  const double late = setup_.command_timeout + set_point.period + tracking_delay();
  return ((set_point.target.q - measured().q).cwiseAbs().array() > setup_.limits.velocity.array() * late).any();
}

// A command counts as accepted also while the arm is held, so that its planner knows that the driver receives it.
// Of a second writer nothing counts, not even as the reason why the arm stands.
Judgement ArmControl::command(const msg::ArmCommand& command, const std::optional<CommandOrigin>& origin) {
  Judgement judgement = gate_.judge(command, origin);
  if (judgement.verdict == Verdict::kRepeated || judgement.verdict == Verdict::kSecondWriter) return judgement;
  const auto& set_point = gate_.set_point();
  const bool follows = !hold_ && !observed_ && session_.active();
  if (judgement.verdict == Verdict::kAccepted && follows) {
    const bool far = is_far(set_point);
    if (far) stop(continues_from());
    const bool near = !far && interpolator_.command(set_point, continues_from());
    if (!far) reference_at_ = now_;
    if (!near) {
      judgement = {Verdict::kTooFar, make_cause(CauseKind::CAUSE_COMMAND_TOO_FAR, command.node(),
                                                far_text(set_point.target.q, measured().q))};
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
  if (session_.active()) {
    const double dt = std::chrono::duration<double>(now_ + setup_.period - reference_at_).count();
    interpolate();
    approach(interpolator_.reference(), std::max(dt, std::chrono::duration<double>(setup_.period).count()));
    session_.write(written_, setup_.valid_for);
    if (!session_.active()) interpolator_.reset(interpolator_.reference().q);
  }
  ran_ = ran_ || interpolator_.mode() == planner::DriveMode::kTracking;
  leave_to_others();
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

// A planner that has lost track of a lagging device begins again at the measured position. Its set-point then jumps
// back by the lag, and the device must not.
void ArmControl::approach(const planner::JointState& reference, double dt) {
  constexpr double kCatchUp = 1.5;  // times the velocity limits
  if (tracking_delay() > 0.0) {
    const planner::JointVector step = setup_.limits.velocity * (kCatchUp * dt);
    written_.q += (reference.q - written_.q).cwiseMax(-step).cwiseMin(step);
    written_.qd = reference.qd;
  } else {
    written_ = reference;
  }
}

bool ArmControl::moves() const {
  const planner::JointVector& qd = measured().qd;
  return ((qd.array().abs() > kMoving) && (mean_qd_.array().abs() > kMovingOnAverage)).any();
}

msg::ArmMode ArmControl::mode() const {
  if (session_.failed()) return msg::ArmMode::ARM_FAILED;
  if (session_.observed() && measured().q.size() > 0) return msg::ArmMode::ARM_OBSERVED;
  if (interpolator_.mode() == planner::DriveMode::kTracking) return msg::ArmMode::ARM_RUNNING;
  if (interpolator_.mode() == planner::DriveMode::kStopping) return msg::ArmMode::ARM_BRAKING;
  // A device may lag behind the end of the stop profile: the arm has stopped when its measured joints have.
  if ((ran_ || !session_.active()) && moves()) return msg::ArmMode::ARM_BRAKING;
  return ran_ ? msg::ArmMode::ARM_STOPPED : msg::ArmMode::ARM_STARTING;
}

msg::Cause ArmControl::cause() const {
  if (mode() == msg::ArmMode::ARM_RUNNING) return {};
  if (msg::Cause why = session_.cause(); !is_none(why)) return why;
  if (observed_) return observed_cause(setup_.arm);
  if (hold_) return *hold_;
  if (refusal_) return *refusal_;
  if (!commanded_) return make_cause(CauseKind::CAUSE_STARTING, setup_.arm, "no command received yet");
  // The interpolator is one period ahead, so it begins to stop this much earlier. Half a period covers rounding.
  const double ahead = 1.5 * std::chrono::duration<double>(setup_.period).count();
  if (command_age() + ahead > setup_.command_timeout) {
    return make_cause(CauseKind::CAUSE_COMMANDS_CEASED, setup_.arm,
                      milliseconds_text("commands ceased: none for more than %.0f ms", setup_.command_timeout));
  }
  return make_cause(CauseKind::CAUSE_STARTING, setup_.arm, "starts to follow commands");
}

}  // namespace hecaton::services
