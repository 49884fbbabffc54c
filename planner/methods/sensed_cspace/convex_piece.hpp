#pragma once
/// An obstacle's shape in the arm's plane, as the images need it.

#include <span>
#include <vector>

#include "planner/methods/sensed_cspace/planar_arm.hpp"

namespace hecaton::planner::cspace {

/// A side of a convex piece: from `start` on for `length` along the unit vector `along`; `outward` is the unit normal.
struct Edge {
  Point start;
  Point along;
  Point outward;
  double length = 0.0;  ///< [m]
};

/// A point, a line segment or a convex polygon.
struct ConvexPiece {
  std::vector<Point> corners;  ///< counter-clockwise
  std::vector<Edge> edges;     ///< none of a point, one for each side of a segment
  Point centre;
  double radius = 0.0;  ///< no point is farther from the centre [m]
};

/// The convex hull of the points [m], at least one.
[[nodiscard]] ConvexPiece convex_piece(std::span<const Point> points);

/// A polygon without crossings, given by its corners in either order, cut into triangles. Empty when it has no area.
[[nodiscard]] std::vector<ConvexPiece> triangles(std::span<const Point> corners);

}  // namespace hecaton::planner::cspace
