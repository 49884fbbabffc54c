#pragma once
/// The complete planner of one arm: tick, rollouts, replanning and coupled plans in one fixed order (ARCHITECTURE.md).

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planner/arm_controller.hpp"
#include "planner/arm_planner/search_executor.hpp"
#include "planner/rollout/rollout_policy.hpp"
#include "planner/route/multi_arm_coordinator.hpp"
#include "planner/route/route_policy.hpp"

namespace hecaton::planner {

struct ArmPlannerOptions {
  double control_period = 0.010;  ///< [s]
  // Seeds of the random choices; use different ones for each arm.
  std::uint64_t motion_seed = 1;  ///< of the subspaces in ticks
  std::uint64_t rollout_seed = 1;
  std::uint64_t route_seed = 1;
  /// The numbers of this planner's coupled plans begin after this one. A restarted planner must not reuse numbers.
  std::uint32_t plan_numbers_after = 0;

  void describe(MemoryArchive& archive) {
    archive(control_period, motion_seed, rollout_seed, route_seed, plan_numbers_after);
  }
};

struct GoalChange {
  /// New goal [rad | m]; empty: the arm brakes, stays where it comes to rest, and gives way.
  std::optional<JointVector> q_goal = {};
  /// To q_goal, which is its end; null: the planner chooses the motion.
  std::shared_ptr<const TimedTrajectory> trajectory = {};
  double trajectory_time = 0.0;  ///< from which the arm follows it [s]; above 0 when another planner has begun it
};

/// Events since the last period.
struct PeriodEvents {
  double missed = 0.0;             ///< duration of the skipped control periods [s]
  bool drops_setpoint = false;     ///< the drive does not follow the last set-point; start from the measured state
  SharedObstacles obstacles = {};  ///< the cell's new obstacles; null: unchanged
  std::optional<GoalChange> goal = {};
  std::span<const RangeScan> scans = {};  ///< of the arm's own sensors
};

/// State of the cell at the beginning of a period. The spans must stay valid during the period's calls.
struct PeriodInputs {
  OwnArmFeedback own;
  std::span<const ArmObservation> arms;             ///< of the whole cell
  std::span<const world::ObstacleState> obstacles;  ///< of the whole cell, in the order of PeriodEvents::obstacles
  bool hold = false;                                ///< the arm must brake and stay
  double speed = 1.0;                               ///< ordered share of the velocity limits, above 0 to 1
  bool commands = true;      ///< false: another planner commands the arm; this planner asks and proposes nothing
  std::uint64_t number = 0;  ///< growing number of the set-point for the drive; 0: the set-point is not sent
  SearchAnswers answers;
};

/// The planner service and the simulation run this class. Pure: equal memory and inputs give equal set-points, bit by
/// bit. No clock, thread, log or network. Call receive(), step() and plan_ahead() in this order in each period. Not
/// thread-safe.
class ArmPlanner {
 public:
  /// `geometry`: of the cell, with the planner's own arm.
  ArmPlanner(CellGeometry geometry, const LocalParameters& parameters, const ArmPlannerOptions& options);

  /// First call in a period. Allocates when obstacles change.
  void receive(const PeriodEvents& events);
  /// Second call: returns the set-point of this period. No allocation.
  [[nodiscard]] TickResult step(const PeriodInputs& inputs);
  /// Third call: processes answers, decides what the arm does in the next period, and returns new questions. `result`:
  /// of step() with the same inputs.
  [[nodiscard]] SearchQuestions plan_ahead(const PeriodInputs& inputs, const TickResult& result);

  [[nodiscard]] const ArmController& controller() const { return controller_; }
  /// The arm's proposal, to be published; null: none.
  [[nodiscard]] const std::shared_ptr<const CoupledPlan>& proposal() const { return coordinator_.proposal(); }
  [[nodiscard]] const CoupledPlanProgress& progress() const { return coordinator_.progress(); }
  /// Points that the arm goes through next, up to its target: of its coupled plan, its route or its trajectory, else
  /// the goal alone [rad | m]. Dampers and the right of way may lead it elsewhere. Empty: it has no target. Allocates.
  [[nodiscard]] std::vector<JointVector> way() const;
  /// The arm is blocked and its rollouts are running.
  [[nodiscard]] bool awaiting_rollout() const { return rollouts_.awaiting_rollout(); }

  /// Totals since construction.
  struct Counts {
    int rollouts = 0;       ///< answers of the rollout search
    int routes = 0;         ///< begun routes
    int coupled_plans = 0;  ///< proposals
  };
  [[nodiscard]] Counts counts() const { return {rollout_answers_, routes_.begun(), coordinator_.proposed()}; }

  /// The memory as words, from which restore() continues with the same set-points; without the obstacles. Empty: the
  /// arm's method has a guide, whose map cannot be saved.
  [[nodiscard]] std::vector<std::uint32_t> save() const;
  /// Continues from a saved memory. The planner must have been built with the same arguments. False: the words are
  /// those of another planner or version; then it must not be used. Pass all obstacles to receive() next.
  [[nodiscard]] bool restore(std::span<const std::uint32_t> words);

 private:
  void describe(MemoryArchive& archive);

  ArmController controller_;
  RolloutPolicy rollouts_;
  RoutePolicy routes_;
  MultiArmCoordinator coordinator_;
  int rollout_answers_ = 0;
};

}  // namespace hecaton::planner
