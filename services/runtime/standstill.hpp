#pragma once
/// Why an arm stands still, as far as its drive and its goal explain it. Standard library and the generated values
/// only.

#include <string>

#include <idl/arm.h>
#include <idl/goal.h>

namespace hecaton::services {

/// A joint moves faster than 1e-3 rad/s (m/s) times the speed override of the arm.
[[nodiscard]] bool moves(const msg::ArmState& state, double speed = 1.0);

/// Text of a goal's status: "blocked: no way for now (arm2/link4 – pallet, 18 mm)".
[[nodiscard]] std::string goal_text(const msg::GoalStatus& goal);

/// Why the drive does not follow commands, with the kind of its driver's cause. For a drive that is not ARM_RUNNING.
[[nodiscard]] msg::Cause drive_cause(const msg::ArmState& state);

/// True: the drive waits for its first command only, and the goal has ended. Then the arm waits for the next goal.
[[nodiscard]] bool awaits_goal(const msg::ArmState& state, const msg::GoalStatus& goal);

/// Why an arm that stands still is not at its goal, with the kind of its planner's cause. CAUSE_NONE: it is about to
/// move.
[[nodiscard]] msg::Cause goal_cause(const msg::GoalStatus& goal);

}  // namespace hecaton::services
