#pragma once
/// One arm's part in coupled plans: when it proposes one, when it joins another's, where it goes then. Used every
/// control period, beside the tick.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "planner/arm_controller.hpp"
#include "planner/local/coupled_plan.hpp"
#include "planner/route/route_search.hpp"

namespace hecaton::planner {

class MultiArmCoordinator {
 public:
  /// `seed` of the searches. Only an arm whose method coordinates takes part. `numbers_after`: own proposals get greater
  /// numbers; who restarts must not use old ones again.
  MultiArmCoordinator(const LocalParameters& parameters, std::uint64_t seed, std::uint32_t numbers_after = 0);

  /// After a period of `controller`. A question when the arm has the right of way and nevertheless comes no nearer for
  /// long: a plan for itself and all that can come near it.
  [[nodiscard]] std::optional<RouteQuestion> next(const ArmController& controller, const TickResult& result,
                                                  std::span<const ArmObservation> arms,
                                                  std::span<const world::ObstacleState> obstacles);
  void answered(const RouteAnswer& answer);
  /// Another planner commands the arm: this one takes part in nothing, and proposes nothing.
  void resign();

  /// Where the arm goes from the next period on; empty: it follows no coupled plan.
  [[nodiscard]] const std::optional<JointVector>& aim() const { return part_.aim; }

  /// To be published; null: none.
  [[nodiscard]] const std::shared_ptr<const CoupledPlan>& proposal() const { return proposal_; }
  [[nodiscard]] const CoupledPlanProgress& progress() const { return part_.progress; }
  /// The arm goes by a plan.
  [[nodiscard]] bool takes_part() const { return part_.plan != nullptr; }
  /// Plans that were proposed so far.
  [[nodiscard]] int proposed() const { return proposed_; }

 private:
  void join_or_stay(const ArmController& controller, std::span<const ArmObservation> arms);
  void join(int proposer, std::shared_ptr<const CoupledPlan> plan);
  void leave();
  void advance(const ArmController& controller, std::span<const ArmObservation> arms, double dt);
  [[nodiscard]] bool suits(const CoupledPlan& plan, const ArmController& controller) const;
  [[nodiscard]] bool suits_goal(const ArmController& controller) const;
  [[nodiscard]] RouteQuestion make_question(const ArmController& controller, std::span<const ArmObservation> arms,
                                            std::span<const world::ObstacleState> obstacles);

  /// The arm's part in the plan that it follows.
  struct Part {
    std::shared_ptr<const CoupledPlan> plan = nullptr;  ///< null: it follows none
    CoupledPlanProgress progress = {};
    int index = 0;                        ///< of the own arm in the plan
    std::optional<JointVector> aim = {};  ///< the own arm's point [rad | m]
    int together = -1;                    ///< the point that all arms have reached
    double since_together = 0.0;          ///< since that changed [s]
    bool all_joined = false;
  };

  double after_;     ///< with the right of way, and not nearer for so long [s]; 0: never
  double patience_;  ///< until the next question [s]
  Random random_;
  RouteQuestion question_;  ///< the open one
  bool open_ = false;
  bool dropped_ = false;       ///< the answer to the open question is of no use any more
  double since_answer_ = 0.0;  ///< [s]
  std::uint32_t number_;       ///< of the last own proposal
  int proposed_ = 0;
  std::shared_ptr<const CoupledPlan> proposal_;  ///< the own one
  Part part_;
  CoupledPlanProgress last_;  ///< in the plan that it followed before
};

}  // namespace hecaton::planner
