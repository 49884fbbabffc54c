#pragma once
/// The methods of [Lahouar06]: constraints alone, and boundary following where these leave nothing of the way.

#include <algorithm>
#include <cmath>

#include "planner/methods/boundary_following/boundary_follower.hpp"

namespace hecaton::planner {

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
