#pragma once
/// Algorithm 1 of [Li96]: the five critical points of an obstacle.

#include <array>
#include <span>

#include "planner/methods/sensed_cspace/published/fundamental_obstacles.hpp"
#include "planner/methods/sensed_cspace/published/image_database.hpp"

namespace hecaton::planner::cspace {

/// Indices of fundamental obstacles, of which several may be the same.
struct CriticalPoints {
  int nearest = -1;              ///< G₁: least r
  int phi_min = -1;              ///< G₂
  int phi_max = -1;              ///< G₃
  int theta1_min = -1;           ///< G₄: its image begins first
  int theta1_max = -1;           ///< G₅: its image ends last
  double least_theta1 = 0.0;     ///< Θ₁min [rad]
  double largest_theta1 = -1.0;  ///< Θ₁max [rad]; below Θ₁min: the arm cannot touch the obstacle

  friend bool operator==(const CriticalPoints&, const CriticalPoints&) = default;
};

/// Of at least one fundamental obstacle. Angles are compared relative to the first one's φ, so that an obstacle may lie
/// across the negative x axis.
[[nodiscard]] CriticalPoints find_critical_points(std::span<const FundamentalObstacle> obstacles,
                                                  const ImageDatabase& database);

}  // namespace hecaton::planner::cspace
