#pragma once
/// Postures and a task area for cells that leave them open. They follow from the geometry of arms and obstacles.

#include <optional>
#include <span>
#include <vector>

#include "planner/cell.hpp"

namespace hecaton::planner {

/// Postures within the limits in which the arm is clear of itself, the most compact first. Not empty: an arm that
/// always touches itself gets its zero position, or the nearest limits. Deterministic.
[[nodiscard]] std::vector<JointVector> compact_postures(const Arm& arm);

/// Sets the pose "home" of the listed arms to the most compact posture that is clear of other arms at their home poses
/// and of obstacles at t = 0. Where there is none, home stays as it is. Arms whose start is their home start there.
void choose_home_poses(Cell& cell, std::span<const int> arms);

/// A cylinder that the tools of all arms reach, in W; if they have no such volume in common, one in each base frame.
/// Empty if the arms have none in common there either. Deterministic.
[[nodiscard]] std::optional<TaskArea> default_task_area(const Cell& cell);

}  // namespace hecaton::planner
