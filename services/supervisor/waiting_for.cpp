#include "services/supervisor/waiting_for.hpp"

#include <algorithm>
#include <cmath>

#include "services/runtime/goal_state.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

constexpr double kMoving = 1e-3;  // of any joint [rad/s | m/s]

bool moves(const msg::ArmState& state) {
  return std::any_of(state.qd().begin(), state.qd().end(), [](double v) { return std::abs(v) > kMoving; });
}

std::string with(const std::string& head, const std::string& tail) {
  return tail.empty() ? head : head + ": " + tail;
}

std::string binding_text(const msg::GoalStatus& goal) {
  if (!goal.has_binding()) return {};
  return " (" + goal.binding_own() + " – " + goal.binding_other() + ", " +
         std::to_string(std::lround(goal.binding_distance() * 1e3)) + " mm)";
}

std::string held_text(const msg::GoalStatus& goal) {
  if (goal.held_for() < 1.0) return {};
  return ", for " + std::to_string(std::lround(goal.held_for())) + " s";
}

/// What the drive says of itself; empty while it follows commands.
std::string drive_text(const msg::ArmState& state) {
  switch (state.mode()) {
    case msg::ArmMode::ARM_STARTING:
      return with("driver waits for its first command", state.reason());
    case msg::ArmMode::ARM_BRAKING:
      return with("driver brakes", state.reason());
    case msg::ArmMode::ARM_STOPPED:
      return with("driver has stopped", state.reason());
    case msg::ArmMode::ARM_FAILED:
      return with("drive failed", state.reason());
    case msg::ArmMode::ARM_RUNNING:
      break;
  }
  return {};
}

std::string first_awaited(const std::string& arm, const FaultDetector& watch) {
  for (const std::string& node : {driver_node(arm), watch.in_charge(arm), world_node()}) {
    if (std::string awaited = watch.awaited(node); !awaited.empty()) return awaited;
  }
  return {};
}

}  // namespace

std::string goal_text(const msg::GoalStatus& goal) {
  switch (goal.state()) {
    case msg::GoalState::GOAL_ACCEPTED:
      return "goal " + goal.goal() + " accepted, not begun";
    case msg::GoalState::GOAL_ACTIVE:
      return with(goal.trying(), goal.reason()) + binding_text(goal) + held_text(goal);
    case msg::GoalState::GOAL_BLOCKED:
      return with("blocked", goal.reason()) + binding_text(goal) + held_text(goal);
    case msg::GoalState::GOAL_REACHED:
      return "a goal; the last was reached";
    case msg::GoalState::GOAL_REJECTED:
      return with("a goal; the last was rejected", goal.reason());
    case msg::GoalState::GOAL_CANCELLED:
      return "a goal; the last was cancelled";
    case msg::GoalState::GOAL_REPLACED:
      return "the goal that replaced " + goal.goal();
    case msg::GoalState::GOAL_TIMED_OUT:
      return with("a goal; the last timed out", goal.reason());
  }
  return {};
}

std::string waiting_for(const std::string& arm, const FaultDetector& watch, const Picture& picture) {
  if (std::string held = watch.mode().reason_of(arm); !held.empty()) return held;
  if (std::string awaited = first_awaited(arm, watch); !awaited.empty()) return awaited;
  const auto* state = find(picture.arms, arm);
  const auto* goal = find(picture.goals, arm);
  // What comes to rest after its goal has ended waits for the next one already.
  if (state && moves(state->value) && !(goal && is_over(goal->value.state()))) return {};
  const auto* planner = find(picture.heartbeats, watch.in_charge(arm));
  if (planner && planner->value.state() == msg::NodeState::NODE_DEGRADED && !planner->value.detail().empty()) {
    return planner->value.node() + ": " + planner->value.detail();
  }
  if (state) {
    if (std::string drive = drive_text(state->value); !drive.empty()) return drive;
  }
  if (goal) return goal_text(goal->value);
  const auto* lost = find(picture.lost_goals, arm);
  return lost ? "a goal; " + lost->value.goal() + " was lost with the process of " + lost->value.node() : "a goal";
}

}  // namespace hecaton::services
