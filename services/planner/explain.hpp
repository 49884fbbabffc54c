#pragma once
/// Why an arm moves as it does, or does not: the result of a period as kinds and in words.

#include <optional>
#include <span>

#include "planner/approach.hpp"
#include "planner/tick.hpp"
#include "services/planner/goal_manager.hpp"
#include "services/planner/live_planner.hpp"

namespace hecaton::services {

/// State, cause, binding pair and recovery action; the distance to the goal is left to the caller. A reached set-point
/// is reported as active: only the measured state tells whether the arm is there. `hold`: why the tick had to hold.
[[nodiscard]] Progress explain(const planner::TickResult& result, const planner::Approach& approach,
                               const planner::CellGeometry& geometry, std::span<const planner::ArmObservation> arms,
                               std::span<const world::ObstacleState> obstacles, const std::optional<msg::Cause>& hold);

/// Reports the progress of the active goal, period by period.
class ProgressReporter {
 public:
  struct Period {
    const LivePlanner& planner;
    const std::optional<LivePlanner::PlannedPeriod>& planned;  ///< empty: the driver is silent
    const std::optional<msg::Cause>& hold;
    const planner::JointVector* q_goal = nullptr;  ///< of the active goal; null: there is none
  };
  /// Once a period. Empty without an active goal.
  [[nodiscard]] std::optional<Progress> report(const Period& period);

 private:
  double starved_ = 0.0;  ///< the tick had to brake for want of fresh states this long [s]
};

}  // namespace hecaton::services
