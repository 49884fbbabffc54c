#pragma once
/// Where others are by now, going on as they were seen.

#include <span>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/local/observation.hpp"

namespace hecaton::planner {

/// Arm i, within its limits [rad | m].
[[nodiscard]] inline JointVector by_now(const CellGeometry& geometry, std::span<const ArmObservation> arms, int i) {
  const JointLimits& limits = geometry.arms()[i].limits;
  return (arms[i].q + arms[i].qd * arms[i].age).cwiseMax(limits.lower).cwiseMin(limits.upper);
}

[[nodiscard]] inline std::vector<world::ObstacleState> by_now(std::span<const world::ObstacleState> obstacles) {
  std::vector<world::ObstacleState> states(obstacles.begin(), obstacles.end());
  for (world::ObstacleState& state : states) state.X_WO = world::extrapolate(state.X_WO, state.velocity, state.age);
  return states;
}

}  // namespace hecaton::planner
