#pragma once
/// An obstacle as [Li96] sees it: the grid points of the workspace next to its border.

#include <span>
#include <vector>

#include "planner/methods/sensed_cspace/planar_arm.hpp"

namespace hecaton::planner::cspace {

/// FO_i with its two parameters, eq. 1 and 2. differs from paper: φ needs both signs, arctan(y/x) has one.
struct FundamentalObstacle {
  Point place;       ///< [m], both multiples of the grid's spacing
  double r = 0.0;    ///< [m]
  double phi = 0.0;  ///< [rad], −π … π
};

/// Those nearest to the border of the polygon through `corners`, in order along it, each once. `spacing`: δ [m].
[[nodiscard]] std::vector<FundamentalObstacle> border(std::span<const Point> corners, double spacing);

/// Points of the border itself, its corners among them: none of it is farther than half of `spacing` [m] from the
/// nearest of them. Each mapped exactly with that added to the widths (ObstacleMapper), they block every cell in whose
/// centre the arm touches the obstacle, if that is clear of the arm's base: who touches it and is not all inside of it
/// touches its border. What sensors see is such points.
[[nodiscard]] std::vector<Point> border_points(std::span<const Point> corners, double spacing);

}  // namespace hecaton::planner::cspace
