#pragma once
/// The progress of a goal from the result of a control period: state, cause and recovery action.

#include <optional>
#include <span>

#include "planner/goal_progress.hpp"
#include "planner/tick.hpp"
#include "services/planner/goal_manager.hpp"
#include "services/planner/live_planner.hpp"

namespace hecaton::services {

/// State, cause, binding pair and recovery action, without the distance to the goal. The state is never kReached: that
/// depends on the measured position, which the caller checks. `hold`: why the arm is held.
[[nodiscard]] Progress explain(const planner::TickResult& result, const planner::ProgressMonitor& goal_progress,
                               const planner::CellGeometry& geometry, std::span<const planner::ArmObservation> arms,
                               std::span<const world::ObstacleState> obstacles, const std::optional<msg::Cause>& hold);

/// The progress of the active goal, for GoalManager::progress().
class ProgressReporter {
 public:
  struct Period {
    const LivePlanner& planner;
    const std::optional<LivePlanner::PlannedPeriod>& planned;  ///< empty: no fresh state of the arm
    const std::optional<msg::Cause>& hold;
    const planner::JointVector* q_goal = nullptr;  ///< of the active goal; null: there is none
  };
  /// Call it once per control period. Empty without an active goal.
  [[nodiscard]] std::optional<Progress> report(const Period& period);

 private:
  double starved_ = 0.0;  ///< time without fresh inputs [s]
};

}  // namespace hecaton::services
