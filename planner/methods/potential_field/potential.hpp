#pragma once
/// The potentials of a goal and of an obstacle as functions of one distance: [Cardenas10] eq. 2, 3, 6 and 7, with ζ
/// = 1.

namespace hecaton::planner::potential {

/// A potential and its derivative by the distance d.
struct Potential {
  double value = 0.0;
  double slope = 0.0;
};

/// Eq. 2 and 6: a paraboloid around the goal, a cone beyond `goal_distance` (d*_goal > 0); d ≥ 0 [m | rad].
[[nodiscard]] Potential attraction(double d, double goal_distance);

/// Eq. 3 and 7: zero beyond `influence_distance` (Q* > 0), growing without bound towards the obstacle; d [m].
/// Never positive slope: it pushes away. η = `repulsion` [m⁴], so that both potentials are in m².
[[nodiscard]] Potential repulsion(double d, double influence_distance, double repulsion);

}  // namespace hecaton::planner::potential
