#pragma once
/// The methods of [Lahouar06]: constraints alone, and boundary following in a plane of joint space where the constraints
/// leave no progress towards the goal.

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "planner/methods/motion_method.hpp"

namespace hecaton::planner {

/// Of one subspace.
struct FollowerMemory {
  double d_lock = 0.0;                  ///< V(q_lock) = ‖q_lock − q_goal‖ [rad]
  JointVector U1;                       ///< unit, from q_lock to q_goal (eq. 10)
  JointVector U2;                       ///< unit, orthogonal to U1 (eq. 12)
  Eigen::Vector2d A_lock = {1.0, 0.0};  ///< the followed projected constraint, unit (eq. 19)
  double time_in_subspace = 0.0;        ///< [s]
  int switches_in_subspace = 0;         ///< changes of the followed constraint
};

/// What following changes: `deviation` counts the goal's subspaces, and knows whether one is followed now.
struct Follower {
  FollowerMemory& memory;
  Deviation& deviation;
  Random& random;
};

/// Begins to follow at q: subspace P through q, the goal and the joint limits (all upper or all lower, drawn once a
/// goal), or through a random direction after a time-out. `blocking` is the row that stops the local planner.
void start_following(Follower follower, const JointLimits& limits, const JointVector& q, const JointVector& way_to_goal,
                     const Row& blocking);

/// A fresh subspace through q, which becomes q_lock: U₁ to the goal, U₂ random and orthogonal to it.
void redraw_subspace(Follower follower, const JointVector& way_to_goal, std::span<const Row> rows);

/// The plane through q, which becomes q_lock, the goal, and `across` (orthogonalised to the way): the arm turns first
/// to where that points. Does nothing if it points along the way.
void follow_across(Follower follower, const JointVector& way_to_goal, const JointVector& across,
                   std::span<const Row> rows);

/// The joint velocity that follows the boundary: the vertex of the projected constraints on the followed one, in
/// direction S (fig. 9), after switching the followed constraint when another blocks (fig. 10). Zero when nothing in P
/// is possible; nothing when no constraint is left to follow.
[[nodiscard]] std::optional<JointVector> follow_boundary(Follower follower, const VelocityBounds& bounds,
                                                         std::span<const Row> rows);

/// The cell file's map `follower`.
struct FollowerParameters {
  double deadlock_fraction = 0.30;  ///< follow when ‖Δq‖ < this · min(‖q_goal − q‖, Δq_max)  (section 4)
  double exit_fraction = 0.80;      ///< back to the local planner when V(q) < this · d_lock     (section 4)
  double resample_after = 1.0;      ///< [s] in the first subspace before a fresh U₂ is drawn; 0: never (the paper)
  double resample_growth = 1.25;    ///< each further subspace of a goal gets this many times longer, ≥ 1
  int most_switches = 6;            ///< changes of the followed constraint before a fresh U₂ is drawn
  double resample_longest = 8.0;    ///< but no longer than this [s], ≥ resample_after

  /// How long the k-th subspace of a goal may be followed, k = 1, 2, … [s].
  [[nodiscard]] double patience(int k) const {
    return std::min(resample_longest, resample_after * std::pow(resample_growth, k - 1));
  }
};

/// Section 2: straight to the goal under the constraints. The baseline.
class ConstraintsAlone final : public MotionMethod {
 public:
  ConstraintsAlone() : MotionMethod({.name = "local", .summary = "straight to the goal under the constraints"}) {}
};

/// Section 3, in ever fresh subspaces, together with right of way, rollouts, routes and coupled plans.
class BoundaryFollowing : public MotionMethod, public Configured<FollowerParameters> {
 public:
  BoundaryFollowing()
      : BoundaryFollowing({.name = "boundary_following",
                           .summary = "around what is in the way, in ever fresh planes of joint space",
                           .coordinates = true}) {}

  void visit_parameters(ParameterVisitor& visitor) override;
  [[nodiscard]] std::optional<std::string> validate() const override;
  [[nodiscard]] Redirection redirect(const MethodInput& input, const ConstrainedMotion& constrained,
                                     MethodState state) const override;
  [[nodiscard]] bool held_back(const JointVector& possible, const JointVector& wanted) const override;

 protected:
  explicit BoundaryFollowing(const MethodTraits& traits) : MotionMethod(traits) {}

  /// Begins to go around the constraint `blocking`, an index of input.rows; −1: there is none, and nothing to begin.
  virtual void start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const;
  /// The present subspace has led nowhere for so long that another is due.
  [[nodiscard]] virtual bool exhausted(const FollowerMemory& follower, const Deviation& deviation) const;
  /// Goes on another way.
  virtual void renew(const MethodInput& input, const JointVector& way, MethodState state) const;
  /// As part of what the method remembers.
  [[nodiscard]] virtual FollowerMemory& follower_of(MethodMemory& memory) const { return memory.as<FollowerMemory>(); }

 private:
  [[nodiscard]] bool update(const MethodInput& input, const ConstrainedMotion& constrained, const JointVector& way,
                            MethodState state) const;
};

/// Section 3 as published: one subspace as long as it takes, and nothing else.
class SingleSubspace final : public BoundaryFollowing {
 public:
  SingleSubspace()
      : BoundaryFollowing({.name = "single_subspace",
                           .summary = "boundary following as published: in one plane as long as it takes"}) {}

 protected:
  void start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const override;
  [[nodiscard]] bool exhausted(const FollowerMemory& /*follower*/, const Deviation& /*deviation*/) const override {
    return false;
  }
};

}  // namespace hecaton::planner
