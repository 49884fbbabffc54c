#pragma once
/// The planar arm of [Li96], and obstacle shapes in its plane.

#include <span>
#include <vector>

namespace hecaton::planner::cspace {

/// A point of the arm's plane [m]; the base is at the origin, θ₁ counts from the x axis, θ₂ from the first link.
struct Point {
  double x = 0.0;
  double y = 0.0;
};

/// Each link is all that is within its width w of its axis: the paper's eq. 5 and 6, where asin(w/s) is the half-angle
/// under which a disc of radius w is seen from s.
struct PlanarArm {
  double length1 = 20.0;  ///< l₁ [m], > 0
  double length2 = 20.0;  ///< l₂ [m], > 0
  double width1 = 1.0;    ///< w of the first link [m], > 0
  double width2 = 1.0;    ///< w of the second link [m], > 0

  [[nodiscard]] double reach() const { return length1 + length2; }
  /// The same arm, thicker: the image that it makes is that of an obstacle grown by `margin` [m].
  [[nodiscard]] PlanarArm grown(double margin) const { return {length1, length2, width1 + margin, width2 + margin}; }
};

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
