#pragma once
/// An obstacle as [Li96] sees it: the grid points of the workspace next to its border.

#include <span>
#include <vector>

#include "planner/cspace/planar_arm.hpp"

namespace hecaton::planner::cspace {

/// FO_i with its two parameters, eq. 1 and 2. differs from paper: φ needs both signs, arctan(y/x) has one.
struct FundamentalObstacle {
  Point place;       ///< [m], both multiples of the grid's spacing
  double r = 0.0;    ///< [m]
  double phi = 0.0;  ///< [rad], −π … π
};

/// Those nearest to the border of the polygon through `corners`, in order along it, each once. `spacing`: δ [m].
[[nodiscard]] std::vector<FundamentalObstacle> border(std::span<const Point> corners, double spacing);

}  // namespace hecaton::planner::cspace
