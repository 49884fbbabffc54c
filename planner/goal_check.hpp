#pragma once
/// Whether a configuration may be a goal.

#include <span>
#include <string>

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::planner {

/// Empty when `q_goal` may be a goal of the geometry's own arm; otherwise one sentence: wrong number of joints, not
/// finite, outside a limit (joint, value, range), in collision with itself or with an obstacle where that is now (both
/// names, distance) or with what no joint moves of another arm. All else of others is no reason. Allocates.
[[nodiscard]] std::string reject_goal(const CellGeometry& geometry, const JointVector& q_goal,
                                      std::span<const world::ObstacleState> obstacles);

}  // namespace hecaton::planner
