#pragma once
/// Coupled plans of several arms, as seen by one arm: when to propose a plan, when to join one, and which point to move
/// to. Used once in each control period, outside the tick.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planner/arm_controller.hpp"
#include "planner/local/observation.hpp"
#include "planner/route/route_search.hpp"

namespace hecaton::planner {

/// Not thread-safe. Deterministic for a seed.
class MultiArmCoordinator {
 public:
  /// `seed`: of the searches. An arm whose method does not coordinate never participates. `numbers_after`: own
  /// proposals get larger numbers; a planner that restarts must not reuse old ones.
  MultiArmCoordinator(const LocalParameters& parameters, std::uint64_t seed, std::uint32_t numbers_after = 0);

  /// Call after each period of `controller`. Returns a question when the arm has the right of way and its progress has
  /// stalled nevertheless: a plan for this arm and all arms that can come near it.
  [[nodiscard]] std::optional<RouteQuestion> next(const ArmController& controller, const TickResult& result,
                                                  std::span<const ArmObservation> arms,
                                                  std::span<const world::ObstacleState> obstacles);
  /// Takes the answer to the open question; a plan that was found becomes the own proposal.
  void receive(const RouteAnswer& answer);
  /// Call when another planner commands the arm: leaves the plan, and drops proposal and open question.
  void withdraw();

  /// The point to move to from the next period on [rad | m]; empty if the arm follows no coupled plan.
  [[nodiscard]] const std::optional<JointVector>& target() const { return part_.target; }

  /// The own proposal, to be published; null: none.
  [[nodiscard]] const std::shared_ptr<const CoupledPlan>& proposal() const { return proposal_; }
  [[nodiscard]] const CoupledPlanProgress& progress() const { return part_.progress; }
  /// The own arm's points from target() to the end of the plan; empty if the arm follows no coupled plan.
  [[nodiscard]] std::vector<JointVector> left() const;
  /// True while the arm follows a coupled plan.
  [[nodiscard]] bool participating() const { return part_.plan != nullptr; }
  /// Number of plans proposed so far.
  [[nodiscard]] int proposed() const { return proposed_; }

  void describe(MemoryArchive& archive);

 private:
  void choose_plan(const ArmController& controller, std::span<const ArmObservation> arms);
  void join(int proposer, std::shared_ptr<const CoupledPlan> plan);
  void leave();
  /// Index of the point to which the arm goes. Precondition: participating().
  [[nodiscard]] int next_point() const;
  void advance(const ArmController& controller, std::span<const ArmObservation> arms, double dt);
  [[nodiscard]] bool can_join(const CoupledPlan& plan, const ArmController& controller) const;
  [[nodiscard]] bool ends_at_goal(const ArmController& controller) const;
  [[nodiscard]] RouteQuestion make_question(const ArmController& controller, std::span<const ArmObservation> arms,
                                            std::span<const world::ObstacleState> obstacles);

  /// The plan that the arm follows, and its state.
  struct Part {
    std::shared_ptr<const CoupledPlan> plan = nullptr;  ///< null: none
    CoupledPlanProgress progress = {};
    int index = 0;                           ///< of the own arm in plan->arms
    std::optional<JointVector> target = {};  ///< the own arm's next point [rad | m]
    int reached_by_all = -1;                 ///< index of the last point that all arms have reached
    double since_progress = 0.0;             ///< since that changed [s]
    bool all_joined = false;

    void describe(MemoryArchive& archive);
  };

  double stall_timeout_;  ///< without progress, before the arm asks [s]; 0: never
  double interval_;       ///< between two questions [s]
  Random random_;
  RouteQuestion question_;  ///< the open one, valid if open_
  bool open_ = false;
  bool dropped_ = false;       ///< the answer to the open question will be ignored
  double since_answer_ = 0.0;  ///< [s]
  std::uint32_t number_;       ///< of the last own proposal
  int proposed_ = 0;
  std::shared_ptr<const CoupledPlan> proposal_;  ///< the own one
  Part part_;
  CoupledPlanProgress last_;  ///< in the plan that the arm left last
};

}  // namespace hecaton::planner
