#pragma once
/// Causes of holds, faults, refusals and outcomes as values. Decide on their kinds; their texts are for people only.
/// Standard library and the generated values only.

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <idl/cause.h>
#include <idl/goal.h>

namespace hecaton::services {

/// `subject`: the node, host, arm, obstacle, joint or link concerned; `text`: one sentence.
[[nodiscard]] inline msg::Cause make_cause(msg::CauseKind kind, std::string subject, std::string text) {
  msg::Cause cause;
  cause.kind(kind);
  cause.subject(std::move(subject));
  cause.text(std::move(text));
  return cause;
}

/// True when there is nothing to explain.
[[nodiscard]] inline bool is_none(const msg::Cause& cause) {
  return cause.kind() == msg::CauseKind::CAUSE_NONE;
}

/// In the order of msg::CauseKind.
inline constexpr std::array<std::string_view, static_cast<std::size_t>(msg::CauseKind::CAUSE_NOT_PERSISTED) + 1>
    kCauseNames{
        "none",
        // orders and the cell mode
        "starting", "mode_unknown", "hold_ordered", "stop_ordered", "held_by_fault",
        // missing inputs
        "arm_state_old", "obstacles_old", "sensor_old", "node_stopped", "standing_by",
        // commands and the device
        "commands_ceased", "command_refused", "command_too_far", "device_failed", "observed",
        // faults
        "driver_silent", "world_silent", "node_missing", "node_silent", "process_died", "node_failed", "host_lost",
        "host_isolated", "link_lost", "duplicate_node", "persistence_failed", "checkpoint_lost", "input_refused",
        "second_writer", "certificate_expires", "arm_stands", "contact", "device_not_ready", "remote_control_off",
        "program_stopped", "safeguard_stop", "protective_stop", "emergency_stop", "arm_failed",
        // goals
        "no_goal", "goal_malformed", "goal_outside_limits", "goal_in_collision", "goal_unreachable", "goal_orientation",
        "goal_not_resolved", "path_blocked", "at_joint_limits", "giving_way", "device_does_not_follow", "time_limit",
        "path_tolerance", "goal_replaced", "goal_cancelled", "goal_resumed",
        // requests and edits
        "unknown_name", "name_taken", "invalid_value", "not_allowed_now", "not_persisted"};

/// The kind's name in JSON, logs, cell files and checkpoints: "node_silent". A kind of a newer version is "unknown".
[[nodiscard]] inline std::string_view cause_name(msg::CauseKind kind) {
  const auto index = static_cast<std::size_t>(kind);
  return index < kCauseNames.size() ? kCauseNames[index] : "unknown";
}

/// The inverse of cause_name(); empty when no kind has this name.
[[nodiscard]] inline std::optional<msg::CauseKind> cause_kind(std::string_view name) {
  const auto found = std::find(kCauseNames.begin(), kCauseNames.end(), name);
  if (found == kCauseNames.end()) return std::nullopt;
  return static_cast<msg::CauseKind>(found - kCauseNames.begin());
}

/// True for the kinds of the section Faults.
[[nodiscard]] inline bool is_fault(msg::CauseKind kind) {
  return kind >= msg::CauseKind::CAUSE_DRIVER_SILENT && kind <= msg::CauseKind::CAUSE_ARM_FAILED;
}

/// The kinds of faults of an arm's device.
inline constexpr std::array kDeviceFaults{
    msg::CauseKind::CAUSE_DEVICE_NOT_READY, msg::CauseKind::CAUSE_REMOTE_CONTROL_OFF,
    msg::CauseKind::CAUSE_PROGRAM_STOPPED,  msg::CauseKind::CAUSE_SAFEGUARD_STOP,
    msg::CauseKind::CAUSE_PROTECTIVE_STOP,  msg::CauseKind::CAUSE_EMERGENCY_STOP,
    msg::CauseKind::CAUSE_ARM_FAILED};

/// The fault of which a driver's cause reports; empty: its device works.
[[nodiscard]] inline std::optional<msg::CauseKind> device_fault(msg::CauseKind reported) {
  if (reported == msg::CauseKind::CAUSE_DEVICE_FAILED) return msg::CauseKind::CAUSE_ARM_FAILED;
  if (std::find(kDeviceFaults.begin(), kDeviceFaults.end(), reported) == kDeviceFaults.end()) return std::nullopt;
  return reported;
}

/// True for the kinds that explain a goal's state, CAUSE_NO_GOAL excluded.
[[nodiscard]] inline bool is_about_goal(msg::CauseKind kind) {
  return kind >= msg::CauseKind::CAUSE_GOAL_MALFORMED && kind <= msg::CauseKind::CAUSE_GOAL_RESUMED;
}

}  // namespace hecaton::services

namespace hecaton::msg {

/// True when the goal has ended: its state does not change any more. In the namespace of the messages, so that
/// `is_final(status.state())` finds it from everywhere.
[[nodiscard]] inline bool is_final(GoalState state) {
  switch (state) {
    case GoalState::GOAL_ACCEPTED:
    case GoalState::GOAL_ACTIVE:
    case GoalState::GOAL_BLOCKED:
      return false;
    case GoalState::GOAL_REACHED:
    case GoalState::GOAL_REJECTED:
    case GoalState::GOAL_CANCELLED:
    case GoalState::GOAL_REPLACED:
    case GoalState::GOAL_TIMED_OUT:
      return true;
  }
  return false;
}

}  // namespace hecaton::msg
