#include "services/runtime/standstill.hpp"

#include <algorithm>
#include <cmath>

#include "services/runtime/cause.hpp"

namespace hecaton::services {
namespace {

constexpr double kMoving = 1e-3;  // velocity of any joint [rad/s | m/s]

std::string with(const std::string& head, const std::string& tail) {
  return tail.empty() ? head : head + ": " + tail;
}

std::string binding_text(const msg::GoalStatus& goal) {
  if (!goal.has_binding()) return {};
  return " (" + goal.binding_own() + " – " + goal.binding_other() + ", " +
         std::to_string(std::lround(goal.binding_distance() * 1e3)) + " mm)";
}

std::string held_text(const msg::GoalStatus& goal) {
  if (goal.blocked_duration() < 1.0) return {};
  return ", for " + std::to_string(std::lround(goal.blocked_duration())) + " s";
}

/// State of the drive; empty while it follows commands.
std::string drive_text(const msg::ArmState& state) {
  switch (state.mode()) {
    case msg::ArmMode::ARM_STARTING:
      return with("driver waits for its first command", state.cause().text());
    case msg::ArmMode::ARM_BRAKING:
      return with("driver brakes", state.cause().text());
    case msg::ArmMode::ARM_STOPPED:
      return with("driver has stopped", state.cause().text());
    case msg::ArmMode::ARM_FAILED:
      return with("drive failed", state.cause().text());
    case msg::ArmMode::ARM_OBSERVED:
      return with("observed", state.cause().text());
    case msg::ArmMode::ARM_RUNNING:
      break;
  }
  return {};
}

}  // namespace

bool moves(const msg::ArmState& state, double speed) {
  const double slowest = kMoving * speed;
  return std::any_of(state.qd().begin(), state.qd().end(), [&](double v) { return std::abs(v) > slowest; });
}

std::string goal_text(const msg::GoalStatus& goal) {
  switch (goal.state()) {
    case msg::GoalState::GOAL_ACCEPTED:
      return "goal " + goal.goal() + " accepted, not begun";
    case msg::GoalState::GOAL_ACTIVE:
      return with(goal.recovery_action(), goal.cause().text()) + binding_text(goal) + held_text(goal);
    case msg::GoalState::GOAL_BLOCKED:
      return with("blocked", goal.cause().text()) + binding_text(goal) + held_text(goal);
    case msg::GoalState::GOAL_REACHED:
      return "a goal; the last was reached";
    case msg::GoalState::GOAL_REJECTED:
      return with("a goal; the last was rejected", goal.cause().text());
    case msg::GoalState::GOAL_CANCELLED:
      return "a goal; the last was cancelled";
    case msg::GoalState::GOAL_REPLACED:
      return "the goal that replaced " + goal.goal();
    case msg::GoalState::GOAL_TIMED_OUT:
      return with("a goal; the last timed out", goal.cause().text());
  }
  return {};
}

msg::Cause drive_cause(const msg::ArmState& state) {
  msg::Cause cause = state.cause();
  if (is_none(cause)) cause = make_cause(msg::CauseKind::CAUSE_STARTING, state.arm(), {});
  cause.text(drive_text(state));
  return cause;
}

bool awaits_goal(const msg::ArmState& state, const msg::GoalStatus& goal) {
  const bool starts = is_none(state.cause()) || state.cause().kind() == msg::CauseKind::CAUSE_STARTING;
  return state.mode() == msg::ArmMode::ARM_STARTING && starts && is_final(goal.state());
}

msg::Cause goal_cause(const msg::GoalStatus& goal) {
  msg::Cause cause = goal.cause();
  if (is_final(goal.state())) {
    cause = make_cause(msg::CauseKind::CAUSE_NO_GOAL, {}, {});
  } else if (is_none(cause)) {
    const bool is_active = goal.state() == msg::GoalState::GOAL_ACTIVE;
    if (is_active && !goal.has_binding() && goal.recovery_action().empty()) return {};
    const bool is_blocked =
        goal.state() == msg::GoalState::GOAL_BLOCKED || goal.has_binding() || goal.blocked_duration() > 0.0;
    cause = make_cause(is_blocked ? msg::CauseKind::CAUSE_PATH_BLOCKED : msg::CauseKind::CAUSE_STARTING,
                       goal.binding_other(), {});
  }
  cause.text(goal_text(goal));
  return cause;
}

}  // namespace hecaton::services
