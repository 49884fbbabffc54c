#pragma once
/// One arm's part in composite plans: when it proposes one, when it joins another's, where it goes then. Used every
/// control period, beside the tick.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "planner/arm_controller.hpp"
#include "planner/local/composite_plan.hpp"
#include "planner/route/route_search.hpp"

namespace hecaton::planner {

class CompositePolicy {
 public:
  /// `seed` of the searches. Only an arm whose method coordinates takes part. `numbers_after`: own proposals get
  /// greater numbers; who restarts must not use old ones again.
  CompositePolicy(const LocalParameters& parameters, std::uint64_t seed, std::uint32_t numbers_after = 0);

  /// After a period of `controller`, which it leads by the points of the plan while the arm takes part in one. A
  /// question when the arm has the right of way and nevertheless comes no nearer for long: a plan for itself and all
  /// that can come near it.
  [[nodiscard]] std::optional<RouteQuestion> next(ArmController& controller, const TickResult& result,
                                                  std::span<const ArmObservation> arms,
                                                  std::span<const world::ObstacleState> obstacles);
  void answered(const RouteAnswer& answer);
  /// Somebody else commands the arm: it takes part in nothing, and proposes nothing.
  void resign(ArmController& controller);

  /// To be published; null: none.
  [[nodiscard]] const std::shared_ptr<const CompositePlan>& proposal() const { return proposal_; }
  [[nodiscard]] const CompositeProgress& progress() const { return progress_; }
  /// The arm goes by a plan.
  [[nodiscard]] bool takes_part() const { return plan_ != nullptr; }
  /// Plans that were proposed so far.
  [[nodiscard]] int proposed() const { return proposed_; }

 private:
  void join_or_stay(ArmController& controller, std::span<const ArmObservation> arms);
  void join(int proposer, std::shared_ptr<const CompositePlan> plan);
  void leave(ArmController& controller);
  void advance(ArmController& controller, std::span<const ArmObservation> arms, double dt);
  [[nodiscard]] bool suits(const CompositePlan& plan, const ArmController& controller) const;
  [[nodiscard]] bool suits_goal(const ArmController& controller) const;
  [[nodiscard]] RouteQuestion make_question(const ArmController& controller, std::span<const ArmObservation> arms,
                                            std::span<const world::ObstacleState> obstacles);

  double after_;     ///< with the right of way, and not nearer for so long [s]; 0: never
  double patience_;  ///< until the next question [s]
  Random random_;
  RouteQuestion question_;  ///< the open one
  bool open_ = false;
  bool dropped_ = false;       ///< the answer to the open question is of no use any more
  double since_answer_ = 0.0;  ///< [s]
  std::uint32_t number_;       ///< of the last own proposal
  int proposed_ = 0;
  std::shared_ptr<const CompositePlan> proposal_;  ///< the own one
  std::shared_ptr<const CompositePlan> plan_;      ///< that the arm takes part in
  CompositeProgress progress_;
  CompositeProgress last_;     ///< the plan that it took part in last
  int index_ = 0;              ///< of the own arm in plan_
  int together_ = -1;          ///< the point that all arms have reached
  double since_together_ = 0;  ///< since that changed [s]
  bool all_joined_ = false;
};

}  // namespace hecaton::planner
