#pragma once
/// Why an arm moves as it does, or does not: a tick's result in words.

#include <span>
#include <string>

#include "planner/approach.hpp"
#include "planner/tick.hpp"
#include "services/planner/goal_desk.hpp"

namespace hecaton::services {

/// State, reason, binding pair and what is being tried; the distance to the goal is left to the caller. A reached
/// set-point is told as active: whether the arm is there, only its measured state says.
/// `hold_reason`: why the tick was told to hold.
[[nodiscard]] Progress explain(const planner::TickResult& result, const planner::Approach& approach,
                               const planner::CellGeometry& geometry, std::span<const planner::ArmObservation> arms,
                               std::span<const world::ObstacleState> obstacles, const std::string& hold_reason);

}  // namespace hecaton::services
