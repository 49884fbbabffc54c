#include "services/arm_driver/tool_control.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include "planner/model/outside_joints.hpp"
#include "services/arm_driver/grasp.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/state_period.hpp"

namespace hecaton::services {
namespace {

using msg::CauseKind;

/// The world attaches and detaches within some of its periods.
constexpr std::chrono::seconds kWorldAnswer{2};
/// An arm that has just reached its goal moves on for a moment.
constexpr std::chrono::seconds kComesToRest{1};
/// The planner of the arm then knows, too, that the obstacle belongs to the arm: fingers may come near.
constexpr std::chrono::milliseconds kPlannersKnow{100};
/// A device that moves fingers for longer does not get there.
constexpr std::chrono::seconds kLongestMotion{10};
/// A finger that is nearer to its target has arrived [rad | m].
constexpr double kArrived = 1e-4;
/// A real gripper that is nearer to its target has arrived, as a share of the way between closed and open.
constexpr double kNear = 0.05;

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

msg::SignalKind to_message(device::SignalKind kind) {
  switch (kind) {
    case device::SignalKind::kDigitalInput:
      return msg::SignalKind::SIGNAL_DIGITAL_INPUT;
    case device::SignalKind::kDigitalOutput:
      return msg::SignalKind::SIGNAL_DIGITAL_OUTPUT;
    case device::SignalKind::kAnalogInput:
      return msg::SignalKind::SIGNAL_ANALOG_INPUT;
    case device::SignalKind::kAnalogOutput:
      break;
  }
  return msg::SignalKind::SIGNAL_ANALOG_OUTPUT;
}

bool is_digital(device::SignalKind kind) {
  return kind == device::SignalKind::kDigitalInput || kind == device::SignalKind::kDigitalOutput;
}

/// No planner that sends commands works with an older state.
std::chrono::nanoseconds longest_state_age(const config::CellFile& file) {
  double longest = 0.0;
  for (const planner::PlannedArm& planned : file.cell.arms) {
    longest = std::max(longest, planned.parameters.state_age_limit);
  }
  return nanoseconds(longest + 2.0 * state_period(file) + 2.0 * file.cell.timing.control_period);
}

}  // namespace

ToolControl::ToolControl(const config::CellFile& file, int arm, std::vector<device::SignalKind> kinds,
                         const std::string& checkpoint, device::ArmDevice& device)
    : arm_(file.cell.arms[arm].arm),
      options_(file.tools[arm]),
      gripper_(options_.gripper),
      kinds_(std::move(kinds)),
      device_(device),
      announced_for_(longest_state_age(file)),
      checkpoint_(checkpoint, arm_.model->outside ? arm_.model->outside->joints.size() : 0, "the tool of the arm"),
      between_(planner::outside_ranges(*arm_.model)),
      positions_(between_.size()),
      signals_(options_.signals.size()) {
  if (const auto kept = checkpoint_.recall()) memory_ = *kept;
  memory_.holding.back() = '\0';
  holding_ = memory_.holding.data();
}

bool ToolControl::takes(msg::DeviceOrder order) {
  return order == msg::DeviceOrder::DEVICE_OPEN_TOOL || order == msg::DeviceOrder::DEVICE_CLOSE_TOOL ||
         order == msg::DeviceOrder::DEVICE_SET_SIGNAL || order == msg::DeviceOrder::DEVICE_PLACE_JOINT;
}

bool ToolControl::present() const {
  return gripper_ || !options_.signals.empty();
}

msg::Cause ToolControl::refused(CauseKind kind, const std::string& subject, const std::string& text) const {
  return make_cause(kind, subject, "arm " + arm_.name + ": " + text);
}

bool ToolControl::is_finger(std::size_t joint) const {
  if (!gripper_) return false;
  const std::string& name = arm_.model->outside->joints[joint].name;
  return std::find(gripper_->joints.begin(), gripper_->joints.end(), name) != gripper_->joints.end();
}

std::vector<double> ToolControl::with_gripper_at(double position) const {
  std::vector<double> positions;
  for (std::size_t i = 0; i < between_.size(); ++i) {
    positions.push_back(is_finger(i) ? position : positions_[i].value_or(between_[i].lower));
  }
  return positions;
}

std::optional<msg::Cause> ToolControl::begin(const msg::DeviceRequest& request, const ToolInputs& inputs) {
  switch (request.order()) {
    case msg::DeviceOrder::DEVICE_SET_SIGNAL:
      return set_signal(request);
    case msg::DeviceOrder::DEVICE_PLACE_JOINT:
      return place_joint(request);
    default:
      return begin_gripper(request, inputs);
  }
}

std::optional<msg::Cause> ToolControl::begin_gripper(const msg::DeviceRequest& request, const ToolInputs& inputs) {
  const auto not_now = [&](const std::string& text) {
    return refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, arm_.name, text);
  };
  if (!gripper_) {
    return refused(CauseKind::CAUSE_UNKNOWN_NAME, arm_.name, "it has no gripper; give it one with the key gripper");
  }
  if (phase_ != Phase::kIdle) return not_now("its gripper carries out another order: wait for its end");
  if (inputs.stopped) return not_now("it is stopped: resume it first");
  closing_ = request.order() == msg::DeviceOrder::DEVICE_CLOSE_TOOL;
  double position = closing_ ? gripper_->closed : gripper_->opened;
  if (request.width() >= 0.0) {
    if (moves_by_signals()) return not_now("its gripper has only two positions: leave the width out");
    if (gripper_->width <= 0.0) return not_now("the cell file does not say how wide its gripper opens: gripper.width");
    if (request.width() > gripper_->width) {
      return refused(
          CauseKind::CAUSE_INVALID_VALUE, "width",
          "width = " + number_text(request.width()) + " m must be at most " + number_text(gripper_->width) + " m");
    }
    position = gripper_->closed + request.width() / gripper_->width * (gripper_->opened - gripper_->closed);
  }
  if (request.force() >= 0.0 && moves_by_signals()) return not_now("signals set no force: leave the force out");
  if (closing_ && !holding_.empty()) return not_now("its gripper holds " + holding_ + ": open it first");
  if (inputs.q.size() == 0) return not_now("its position is not known yet");
  position_ = position;
  force_ = request.force();
  phase_ = Phase::kStanding;
  since_ = inputs.now;
  return std::nullopt;
}

// The arm stands.
void ToolControl::prepare(const ToolInputs& inputs) {
  target_ = with_gripper_at(position_);
  grasping_.clear();
  contact_.reset();
  after_release_ = msg::Cause();
  if (closing_ && !gripper_->joints.empty()) {
    std::vector<double> from;
    for (std::size_t i = 0; i < between_.size(); ++i) {
      // From where the fingers may be, farthest from where they close.
      const bool up = is_finger(i) && position_ < between_[i].upper;
      from.push_back(positions_[i].value_or(up ? between_[i].upper : between_[i].lower));
    }
    if (const auto grasp = find_grasp(arm_, inputs.q, from, target_, inputs.obstacles())) {
      grasping_ = grasp->obstacle;
      for (std::size_t i = 0; i < between_.size(); ++i) {
        if (is_finger(i)) contact_ = grasp->positions[i];
      }
      // A real gripper closes as far as the object lets it.
      if (!moves_by_signals() && !yields()) target_ = grasp->positions;
    }
  }
  phase_ = Phase::kAttaching;
  since_ = inputs.now;
  if (grasping_.empty()) announce(inputs.now);
}

void ToolControl::include_target() {
  for (std::size_t i = 0; i < between_.size(); ++i) {
    if (!is_finger(i)) continue;
    between_[i].lower = std::min(between_[i].lower, target_[i]);
    between_[i].upper = std::max(between_[i].upper, target_[i]);
  }
}

void ToolControl::announce(device::Clock::time_point now) {
  include_target();
  phase_ = Phase::kAnnouncing;
  since_ = now;
}

std::optional<msg::Cause> ToolControl::set_signal(const msg::DeviceRequest& request) {
  const auto found = std::find_if(options_.signals.begin(), options_.signals.end(),
                                  [&](const config::SignalOptions& signal) { return signal.name == request.name(); });
  if (found == options_.signals.end()) {
    std::string names;
    for (const config::SignalOptions& signal : options_.signals) names += (names.empty() ? "" : ", ") + signal.name;
    return refused(CauseKind::CAUSE_UNKNOWN_NAME, request.name(),
                   "it has no signal " + request.name() + (names.empty() ? "" : "; it has " + names));
  }
  const auto index = static_cast<std::size_t>(found - options_.signals.begin());
  if (is_digital(kinds_[index]) && request.value() != 0.0 && request.value() != 1.0) {
    return refused(
        CauseKind::CAUSE_INVALID_VALUE, request.name(),
        "signal " + request.name() + " = " + number_text(request.value()) + " must be 0 or 1: it is digital");
  }
  if (auto failure = device_.set_signal(index, request.value())) {
    return refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, request.name(), failure->text);
  }
  end_ = msg::Cause();
  return std::nullopt;
}

std::optional<msg::Cause> ToolControl::place_joint(const msg::DeviceRequest& request) {
  const std::string& name = request.name();
  std::size_t index = 0;
  std::string names;
  if (arm_.model->outside) {
    const auto& joints = arm_.model->outside->joints;
    while (index < joints.size() && joints[index].name != name) ++index;
    for (const planner::OutsideJoint& joint : joints) names += (names.empty() ? "" : ", ") + joint.name;
  }
  if (index >= between_.size()) {
    return refused(
        CauseKind::CAUSE_UNKNOWN_NAME, name,
        "it has no joint " + name + " outside the chain with a range" +
            (names.empty() ? ": give one with joints: {" + name + ": [LOWEST, HIGHEST]}" : "; it has " + names));
  }
  const planner::OutsideJoint& joint = arm_.model->outside->joints[index];
  if (is_finger(index)) {
    return refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, name,
                   "joint " + name + " belongs to its gripper: use 'hecaton tool " + arm_.name + "'");
  }
  if (!joint.of_tool) {
    return refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, name,
                   "joint " + name + " moves no link at the tool alone: planners count its whole range");
  }
  if (!(request.value() >= joint.range.lower && request.value() <= joint.range.upper)) {
    return refused(CauseKind::CAUSE_INVALID_VALUE, name,
                   "joint " + name + " = " + number_text(request.value()) + " must be within its range, " +
                       number_text(joint.range.lower) + " to " + number_text(joint.range.upper));
  }
  memory_.placed[index] = request.value();
  memory_.is_placed[index] = true;
  remember();
  positions_[index] = request.value();
  between_[index] = {request.value(), request.value()};
  end_ = msg::Cause();
  return std::nullopt;
}

void ToolControl::remember() {
  memory_.holding = {};
  const std::string& held = holding_.empty() ? releasing_ : holding_;
  std::memcpy(memory_.holding.data(), held.data(), std::min(held.size(), memory_.holding.size() - 1));
  checkpoint_.remember(memory_);
}

void ToolControl::read_signals() {
  for (std::size_t i = 0; i < signals_.size(); ++i) signals_[i] = device_.signal(i);
}

/// Where the fingers are: as the device measures, or as its outputs say.
void ToolControl::read_device() {
  const std::vector<double> measured = device_.outside();
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (measured.size() == positions_.size() && is_finger(i) && !moves_by_signals()) {
      positions_[i] = measured[i];
    } else if (memory_.is_placed[i] && !is_finger(i)) {
      positions_[i] = memory_.placed[i];
    }
  }
}

/// At rest the joints stay between their measured positions; a finger whose position is not known may be anywhere.
void ToolControl::settle() {
  for (std::size_t i = 0; i < between_.size(); ++i) {
    const planner::MotionRange& range = arm_.model->outside->joints[i].range;
    between_[i] = range;
    if (!positions_[i]) continue;
    const double position = std::clamp(*positions_[i], range.lower, range.upper);
    between_[i] = {position, position};
  }
}

device::DeviceResult ToolControl::start_moving(bool& begun) {
  if (!moves_by_signals()) return device_.move_outside(target_, force_);
  for (const auto& [name, value] : closing_ ? gripper_->close : gripper_->open) {
    const auto is_it = [&wanted = name](const config::SignalOptions& signal) { return signal.name == wanted; };
    const auto found = std::find_if(options_.signals.begin(), options_.signals.end(), is_it);
    if (auto failure = device_.set_signal(static_cast<std::size_t>(found - options_.signals.begin()), value)) {
      return failure;
    }
    begun = true;
  }
  return {};
}

std::optional<double> ToolControl::finger() const {
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (is_finger(i)) return positions_[i];
  }
  return std::nullopt;
}

/// A measured finger that others move, or whose position becomes known, is where it is measured.
void ToolControl::follow_fingers() {
  if (!yields()) return;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (!is_finger(i) || !positions_[i]) continue;
    const planner::MotionRange& range = arm_.model->outside->joints[i].range;
    const double position = std::clamp(*positions_[i], range.lower, range.upper);
    const bool known = between_[i].upper - between_[i].lower < range.upper - range.lower;
    if (known && position > between_[i].lower - kArrived && position < between_[i].upper + kArrived) continue;
    between_[i] = {position, position};
  }
}

bool ToolControl::arrived(device::Clock::time_point now) const {
  if (moves_by_signals()) return now - since_ >= gripper_->time;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (is_finger(i) && (!positions_[i] || std::abs(*positions_[i] - target_[i]) > kArrived)) return false;
  }
  return true;
}

void ToolControl::update(const ToolInputs& inputs) {
  read_signals();
  read_device();
  if (!begun_) {
    begun_ = true;
    settle();
  }
  if (phase_ == Phase::kIdle) follow_fingers();
  const auto is_attached = [&](const std::string& name) {
    const auto found = inputs.attached.find(name);
    return found != inputs.attached.end() && found->second;
  };
  const auto described = inputs.attached.find(holding_);
  // A person has detached it by an edit.
  if (phase_ == Phase::kIdle && described != inputs.attached.end() && !described->second) {
    holding_.clear();
    remember();
  }
  if (!releasing_.empty() && !is_attached(releasing_)) {
    releasing_.clear();
    remember();
  }
  const auto waited = inputs.now - since_;
  // The world may be attaching what it was asked for: that comes to its end first.
  const bool is_prepared =
      phase_ == Phase::kStanding || phase_ == Phase::kAnnouncing || (phase_ == Phase::kAttaching && grasping_.empty());
  if (inputs.stopped && is_prepared) {
    return give_up(inputs, refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, arm_.name,
                                   "it was stopped before its gripper moved: resume it, then call again"));
  }
  switch (phase_) {
    case Phase::kIdle:
      return;
    case Phase::kStanding:
      if (!inputs.moves) {
        prepare(inputs);
      } else if (waited > kComesToRest) {
        finish(refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, arm_.name, "it moves: wait until it stands"));
      }
      return;
    case Phase::kAttaching:
      if (!grasping_.empty() && is_attached(grasping_)) {
        holding_ = std::exchange(grasping_, {});
        remember();
        since_ = inputs.now;
      } else if (!grasping_.empty() && waited > kWorldAnswer) {
        const std::string name = std::exchange(grasping_, {});
        finish(refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, name,
                       "the world has not attached " + name + " within 2 s: see the log of the world"));
      } else if (grasping_.empty() && waited > kPlannersKnow) {
        announce(inputs.now);
      }
      return;
    case Phase::kAnnouncing:
      if (inputs.moves && waited > kLongestMotion) {
        return give_up(inputs, refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, arm_.name, "it moves: wait until it stands"));
      }
      if (waited < announced_for_ || inputs.moves) return;
      phase_ = Phase::kMoving;
      since_ = inputs.now;
      if (bool begun = false; auto failure = start_moving(begun)) {
        msg::Cause why = refused(CauseKind::CAUSE_DEVICE_FAILED, arm_.name, failure->text);
        if (begun) return finish(std::move(why));
        give_up(inputs, std::move(why));
      }
      return;
    case Phase::kMoving:
      if (auto end = yields() ? device_.outside_end() : std::nullopt) {
        read_device();  // the end is newer than what was read before
        if (!end->result) return end_motion(inputs);
        settle();
        include_target();
        return finish(refused(CauseKind::CAUSE_DEVICE_FAILED, arm_.name, end->result->text));
      }
      if (yields() || !arrived(inputs.now)) {
        if (waited < kLongestMotion) return;
        return finish(
            refused(CauseKind::CAUSE_DEVICE_FAILED, arm_.name, "its gripper has not arrived within 10 s: look at it"));
      }
      return end_motion(inputs);
    case Phase::kReleasing:
      if (releasing_.empty()) return finish(after_release_);
      if (waited < kWorldAnswer) return;
      return finish(refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, releasing_,
                            "its gripper is open, but the world has not detached " + releasing_ +
                                " within 2 s; it does so as soon as it runs"));
  }
}

/// The fingers are there, or hold something.
void ToolControl::end_motion(const ToolInputs& inputs) {
  if (moves_by_signals() || !finger()) {
    // Without a measurement a finger that holds something is anywhere on its way.
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      if (is_finger(i)) positions_[i] = closing_ && !holding_.empty() ? std::nullopt : std::optional(target_[i]);
    }
  }
  settle();
  if (!moves_by_signals()) include_target();
  const double range = gripper_->joints.empty() ? 0.0 : std::abs(gripper_->opened - gripper_->closed);
  if (yields() && finger()) {
    const double rest = std::abs(*finger() - position_);
    if (!closing_ && rest > kNear * range) {
      return finish(refused(CauseKind::CAUSE_DEVICE_FAILED, arm_.name,
                            "its gripper stands at " + number_text(*finger()) + " instead of " +
                                number_text(position_) + ": look whether something stops its fingers"));
    }
    // The fingers have passed the place where the obstacle should have stopped them.
    const bool passed = contact_ && std::abs(*contact_ - position_) > 2.0 * kNear * range && rest <= kNear * range;
    if (closing_ && passed && !holding_.empty()) {
      return release(inputs,
                     refused(CauseKind::CAUSE_NOT_ALLOWED_NOW, holding_,
                             "its gripper is closed and holds nothing: " + holding_ + " is not where the cell has it"));
    }
  }
  if (closing_ || holding_.empty()) return finish({});
  release(inputs, {});
}

void ToolControl::release(const ToolInputs& inputs, msg::Cause end) {
  after_release_ = std::move(end);
  releasing_ = std::exchange(holding_, {});
  remember();
  phase_ = Phase::kReleasing;
  since_ = inputs.now;
}

// Other arms and this one avoid an obstacle that stays where it is.
void ToolControl::give_up(const ToolInputs& inputs, msg::Cause why) {
  settle();
  if (!closing_ || holding_.empty()) return finish(std::move(why));
  release(inputs, std::move(why));
}

void ToolControl::finish(msg::Cause cause) {
  phase_ = Phase::kIdle;
  end_ = std::move(cause);
}

std::optional<msg::Cause> ToolControl::end() {
  return std::exchange(end_, std::nullopt);
}

std::optional<double> ToolControl::width() const {
  if (!gripper_ || gripper_->width <= 0.0) return std::nullopt;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (!is_finger(i) || !positions_[i]) continue;
    return std::max(0.0, gripper_->width * (*positions_[i] - gripper_->closed) / (gripper_->opened - gripper_->closed));
  }
  return std::nullopt;
}

void ToolControl::write(msg::ArmState& state) const {
  state.outside().clear();
  state.outside_lower().clear();
  state.outside_upper().clear();
  for (std::size_t i = 0; i < between_.size(); ++i) {
    state.outside().push_back(positions_[i].value_or(0.5 * (between_[i].lower + between_[i].upper)));
    state.outside_lower().push_back(between_[i].lower);
    state.outside_upper().push_back(between_[i].upper);
  }
}

void ToolControl::write(msg::ToolState& state) const {
  state.arm(arm_.name);
  state.has_gripper(gripper_.has_value());
  state.moving(phase_ == Phase::kMoving);
  state.width(width().value_or(-1.0));
  state.grasping(grasping_);
  state.holding(holding_);
  state.releasing(releasing_);
  state.signals().clear();
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    msg::Signal signal;
    signal.name(options_.signals[i].name);
    signal.kind(to_message(kinds_[i]));
    signal.known(signals_[i].has_value());
    signal.value(signals_[i].value_or(0.0));
    state.signals().push_back(std::move(signal));
  }
}

}  // namespace hecaton::services
