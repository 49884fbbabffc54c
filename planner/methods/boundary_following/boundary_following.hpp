#pragma once
/// The methods of [Lahouar06]: constraints alone, and boundary following in a plane of joint space where the
/// constraints leave no progress towards the goal.

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "planner/methods/motion_method.hpp"

namespace hecaton::planner {

/// State of boundary following in one subspace P, the plane through q_lock spanned by U1 and U2.
struct FollowerMemory {
  double d_lock = 0.0;                  ///< V(q_lock) = ‖q_lock − q_goal‖ [rad]
  JointVector U1;                       ///< unit, from q_lock to q_goal (eq. 10)
  JointVector U2;                       ///< unit, orthogonal to U1 (eq. 12)
  Eigen::Vector2d A_lock = {1.0, 0.0};  ///< the followed projected constraint, unit (eq. 19)
  double time_in_subspace = 0.0;        ///< [s]
  int switches_in_subspace = 0;         ///< changes of the followed constraint

  void describe(MemoryArchive& archive) {
    archive(d_lock, U1, U2);
    archive.coordinates(A_lock);
    archive(time_in_subspace);
    archive.count(switches_in_subspace);
  }
};

/// State that the functions below change.
struct BoundaryFollower {
  FollowerMemory& memory;
  Deviation& deviation;
  Random& random;
};

/// Begins boundary following at q. The first subspace of a goal contains q, the goal, and the upper or lower joint
/// limits (drawn at random). Further subspaces contain a random direction. `blocking`: the row that blocks the arm.
void start_following(BoundaryFollower follower, const JointLimits& limits, const JointVector& q,
                     const JointVector& way_to_goal, const Row& blocking);

/// A new subspace through q, which becomes q_lock: U₁ to the goal, U₂ random and orthogonal to it.
void resample_subspace(BoundaryFollower follower, const JointVector& way_to_goal, std::span<const Row> rows);

/// A new subspace through q, which becomes q_lock: U₁ to the goal, U₂ the part of `across` orthogonal to it. The arm
/// turns towards U₂ first. No effect if `across` is parallel to `way_to_goal`.
void follow_across(BoundaryFollower follower, const JointVector& way_to_goal, const JointVector& across,
                   std::span<const Row> rows);

/// The joint velocity along the boundary: the vertex of the projected constraints on the followed one, in direction S
/// (fig. 9). The followed constraint changes when another one blocks (fig. 10). Zero if no motion in P is possible;
/// nothing if no constraint is left to follow.
[[nodiscard]] std::optional<JointVector> follow_boundary(BoundaryFollower follower, const VelocityBounds& bounds,
                                                         std::span<const Row> rows);

/// The cell file's map `follower`.
struct FollowerParameters {
  double deadlock_fraction = 0.30;  ///< follow when ‖Δq‖ < this · min(‖q_goal − q‖, Δq_max)  (section 4)
  double exit_fraction = 0.80;      ///< back to the local planner when V(q) < this · d_lock     (section 4)
  double resample_after = 1.0;      ///< time in the first subspace before a new U₂ is drawn [s]; 0: never (the paper)
  double resample_growth = 1.25;    ///< factor of that time for each further subspace of a goal, ≥ 1
  int most_switches = 6;            ///< changes of the followed constraint before a new U₂ is drawn
  double resample_longest = 8.0;    ///< limit of that time [s], ≥ resample_after

  /// Time limit of the k-th subspace of a goal, k = 1, 2, … [s].
  [[nodiscard]] double subspace_time(int k) const {
    return std::min(resample_longest, resample_after * std::pow(resample_growth, k - 1));
  }
};

/// Section 2: straight to the goal under the constraints, without boundary following.
class ConstraintsAlone final : public MotionMethod {
 public:
  ConstraintsAlone() : MotionMethod({.name = "local", .summary = "straight to the goal under the constraints"}) {}
};

/// Section 3 with a new subspace after each time limit, and with right of way, rollouts, replanning and coupled plans.
class BoundaryFollowing : public MotionMethod, public Configured<FollowerParameters> {
 public:
  BoundaryFollowing()
      : BoundaryFollowing({.name = "boundary_following",
                           .summary = "around obstacles, in a new plane of joint space after each time limit",
                           .coordinates = true}) {}

  void visit_parameters(ParameterVisitor& visitor) override;
  [[nodiscard]] std::optional<std::string> validate() const override;
  [[nodiscard]] Redirection redirect(const MethodInput& input, const ConstrainedMotion& constrained,
                                     MethodState state) const override;
  [[nodiscard]] bool is_blocked(const JointVector& possible, const JointVector& wanted) const override;
  void prepare(MethodMemory& memory) const override { static_cast<void>(follower_of(memory)); }

 protected:
  explicit BoundaryFollowing(const MethodTraits& traits) : MotionMethod(traits) {}

  /// Begins to follow the row `blocking`, an index of input.rows; −1: no effect.
  virtual void start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const;
  /// True if the present subspace has reached its time limit.
  [[nodiscard]] virtual bool exhausted(const FollowerMemory& follower, const Deviation& deviation) const;
  /// Starts a new subspace.
  virtual void renew(const MethodInput& input, const JointVector& way, MethodState state) const;
  /// The part of the method's memory for boundary following.
  [[nodiscard]] virtual FollowerMemory& follower_of(MethodMemory& memory) const { return memory.as<FollowerMemory>(); }

 private:
  [[nodiscard]] bool update(const MethodInput& input, const ConstrainedMotion& constrained, const JointVector& way,
                            MethodState state) const;
};

/// Section 3 as published: one subspace without time limit.
class SingleSubspace final : public BoundaryFollowing {
 public:
  SingleSubspace()
      : BoundaryFollowing({.name = "single_subspace",
                           .summary = "boundary following as published: in one plane without time limit"}) {}

 protected:
  void start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const override;
  [[nodiscard]] bool exhausted(const FollowerMemory& /*follower*/, const Deviation& /*deviation*/) const override {
    return false;
  }
};

}  // namespace hecaton::planner
