#pragma once
/// Algorithm 2 of [Li96]: the image of an obstacle from those of its critical points. For comparison only: it misses
/// cells in which the arm collides (docs/design/0011-sensed-cspace.md).

#include <span>

#include "planner/methods/sensed_cspace/cspace_map.hpp"
#include "planner/methods/sensed_cspace/published/critical_points.hpp"

namespace hecaton::planner::cspace {

/// Fills `image` with what lies between Θ₂l(m) and Θ₂u(m).
void map_as_published(std::span<const FundamentalObstacle> obstacles, const CriticalPoints& critical,
                      const ImageDatabase& database, ObstacleImage& image);

/// The same rows and interpolation, but of all fundamental obstacles, each for itself: eq. 7.
void map_union(std::span<const FundamentalObstacle> obstacles, const ImageDatabase& database, CspaceMap& map);

}  // namespace hecaton::planner::cspace
