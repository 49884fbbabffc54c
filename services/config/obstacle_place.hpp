#pragma once
/// Whether an obstacle may be put where it is to be, among arms that stand or move: the rule of check_start, for edits
/// of a cell that runs.

#include <optional>
#include <span>
#include <string>

#include "planner/cell.hpp"

namespace hecaton::config {

/// Joint positions of each arm of a cell; nothing for an arm that was never measured.
using MeasuredJoints = std::span<const std::optional<planner::JointVector>>;

/// "north/forearm and crate overlap by 12 mm" when the obstacle at X_WO overlaps what a joint of an arm moves, or what
/// an arm carries, or, unless it stands, an arm's fixed base; empty when it does not. `others`: the cell's obstacles,
/// of which those that arms carry count.
[[nodiscard]] std::string overlap_with_arms(std::span<const planner::PlannedArm> arms, MeasuredJoints q,
                                            std::span<const world::Obstacle> others, const world::Obstacle& obstacle,
                                            const world::Pose& X_WO);

}  // namespace hecaton::config
