#pragma once
/// Boundary following in a plane of joint space [Lahouar06, section 3]: the way around an obstacle when the straight
/// way is blocked.

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

}  // namespace hecaton::planner
