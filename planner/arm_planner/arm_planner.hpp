#pragma once
/// The whole planner of one arm: tick, rollouts, replanning and coupled plans in one fixed order. The planner service
/// and the simulation both run this. It works on values: the same memory and the same inputs give the same set-points,
/// bit by bit. It knows no clock, thread, log or network; docs/design/0017-arm-planner.md.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "planner/arm_controller.hpp"
#include "planner/arm_planner/search_executor.hpp"
#include "planner/rollout/rollout_policy.hpp"
#include "planner/route/multi_arm_coordinator.hpp"
#include "planner/route/route_policy.hpp"

namespace hecaton::planner {

struct ArmPlannerOptions {
  double control_period = 0.010;  ///< [s]
  // Seeds of the random choices: repeatable, and best different for each arm.
  std::uint64_t motion_seed = 1;  ///< of the tick's subspaces
  std::uint64_t rollout_seed = 1;
  std::uint64_t route_seed = 1;
  /// The numbers of this planner's coupled plans begin after this one. A planner that restarts must not reuse numbers.
  std::uint32_t plan_numbers_after = 0;
};

/// A new goal, or none.
struct GoalChange {
  std::optional<JointVector> q_goal =
      {};  ///< [rad | m]; empty: the arm brakes, stays where it comes to rest, and gives way
};

/// What happened since the last period.
struct PeriodEvents {
  double missed = 0.0;          ///< control periods that passed without a set-point [s]
  bool drops_setpoint = false;  ///< the drive does not follow the last set-point: the next one begins where the arm is
  SharedObstacles obstacles = {};  ///< the cell's obstacles, when they are others than before; else null
  std::optional<GoalChange> goal = {};
  std::span<const RangeScan> scans = {};  ///< of the arm's own sensors
};

/// What the planner knows when a period begins.
struct PeriodInputs {
  OwnArmFeedback own;
  std::span<const ArmObservation> arms;             ///< of the whole cell
  std::span<const world::ObstacleState> obstacles;  ///< of the whole cell, in the order of PeriodEvents::obstacles
  bool hold = false;                                ///< the arm must not move
  bool commands = true;      ///< false: another planner commands the arm; this one asks and proposes nothing
  std::uint64_t number = 0;  ///< the set-point goes to the drive under this number, which grows; 0: it does not
  SearchAnswers answers;
};

class ArmPlanner {
 public:
  /// `geometry`: of the cell, with the planner's own arm.
  ArmPlanner(CellGeometry geometry, const LocalParameters& parameters, const ArmPlannerOptions& options);

  /// First in a period. Allocates when obstacles change.
  void receive(const PeriodEvents& events);
  /// Second: the set-point of this period. No allocation.
  [[nodiscard]] TickResult step(const PeriodInputs& inputs);
  /// Third: takes the answers, decides what the arm does from the next period on, and returns new questions. `result`:
  /// of step() in this period, of the same inputs.
  [[nodiscard]] SearchQuestions plan_ahead(const PeriodInputs& inputs, const TickResult& result);

  [[nodiscard]] const ArmController& controller() const { return controller_; }
  /// To be published; null: none.
  [[nodiscard]] const std::shared_ptr<const CoupledPlan>& proposal() const { return coordinator_.proposal(); }
  [[nodiscard]] const CoupledPlanProgress& progress() const { return coordinator_.progress(); }
  /// An arm that is held back waits for the answer of its rollouts.
  [[nodiscard]] bool awaiting_rollout() const { return rollouts_.awaiting_rollout(); }

  /// What this planner did so far.
  struct Counts {
    int rollouts = 0;       ///< answers of the rollout search
    int routes = 0;         ///< routes begun
    int coupled_plans = 0;  ///< proposed
  };
  [[nodiscard]] Counts counts() const { return {rollout_answers_, routes_.found(), coordinator_.proposed()}; }

 private:
  ArmController controller_;
  RolloutPolicy rollouts_;
  RoutePolicy routes_;
  MultiArmCoordinator coordinator_;
  int rollout_answers_ = 0;
};

}  // namespace hecaton::planner
