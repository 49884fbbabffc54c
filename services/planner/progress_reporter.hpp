#pragma once
/// The progress of a goal from the result of a control period: state, cause and recovery action.

#include <optional>
#include <span>
#include <string>

#include "planner/arm_planner/arm_planner.hpp"
#include "planner/goal_progress.hpp"
#include "planner/tick.hpp"
#include "services/planner/goal_manager.hpp"

namespace hecaton::services {

/// State, cause, binding pair and recovery action, without the distance to the goal. The state is never kReached: that
/// depends on the measured position, which the caller checks. `hold`: why the arm is held.
[[nodiscard]] Progress progress_of(const planner::TickResult& result, const planner::ProgressMonitor& goal_progress,
                                   const planner::CellGeometry& geometry, std::span<const planner::ArmObservation> arms,
                                   std::span<const world::ObstacleState> obstacles,
                                   const std::optional<msg::Cause>& hold);

/// Decides by the measured position whether an arm whose set-point is at the goal has reached it.
class ArrivalCheck {
 public:
  /// Call once per control period of `dt` [s] after progress_of(). `error`: error_at_goal() of the measured position;
  /// nothing: the arm is there. `set_point_there`: the set-point is at the goal and at rest. An arm that stays away
  /// from its goal for a second although its set-point is there is blocked: its drive does not follow.
  void judge(bool set_point_there, const std::optional<std::string>& error, const std::string& arm, double dt,
             Progress& progress);

 private:
  double waited_ = 0.0;  ///< with the set-point at the goal [s]
};

/// Remembers the pair of bodies that bounded an arm last, until the arm moves freely. At the limits of a path tolerance
/// no pair bounds an arm, although it stands there because of that one.
class LastBinding {
 public:
  /// Call once per control period after progress_of(). `path_bound`: the arm must stay near a trajectory. Then an arm
  /// at its limits says so, and names the pair.
  void update(bool path_bound, Progress& progress);

 private:
  struct Pair {
    std::string own;
    std::string other;
    double distance;  ///< [m]
  };
  std::optional<Pair> pair_;
};

/// The progress of the active goal, for GoalManager::progress().
class ProgressReporter {
 public:
  /// What the planner read, and its result.
  struct Planned {
    const planner::PeriodInputs& inputs;
    const planner::TickResult& result;
    const planner::JointVector& q;  ///< measured [rad | m]
    const msg::Cause& drive;        ///< why the drive does not follow commands
  };
  struct Period {
    const planner::ArmPlanner& planner;
    const std::optional<Planned>& planned;  ///< empty: no fresh state of the arm
    const std::optional<msg::Cause>& hold;
    const planner::JointVector* q_goal = nullptr;  ///< of the active goal; null: there is none
    const planner::ToolGoal* tool = nullptr;       ///< of the active goal; null: it is no pose goal
    bool commands = true;                          ///< this planner is in charge: it ends a goal whose path is left
  };
  /// Call it once per control period. Empty without an active goal.
  [[nodiscard]] std::optional<Progress> report(const Period& period);

 private:
  double starved_ = 0.0;  ///< time without fresh inputs [s]
  ArrivalCheck arrival_;
  LastBinding last_binding_;
};

}  // namespace hecaton::services
