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

/// An arm of two links in a plane. A link contains all points within its width w of its axis. This is the model of eq.
/// 5 and 6: asin(w/s) is half of the angle that a disc of radius w subtends at distance s.
struct PlanarArm {
  double length1 = 20.0;  ///< l₁ [m], > 0
  double length2 = 20.0;  ///< l₂ [m], > 0
  double width1 = 1.0;    ///< w of the first link [m], > 0
  double width2 = 1.0;    ///< w of the second link [m], > 0

  [[nodiscard]] double reach() const { return length1 + length2; }
  /// The same arm with thicker links: equivalent to obstacles grown by `margin` [m].
  [[nodiscard]] PlanarArm grown(double margin) const { return {length1, length2, width1 + margin, width2 + margin}; }
};

/// A side of a convex piece, from `start` along the unit vector `along`. `outward`: unit normal.
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
  double radius = 0.0;  ///< largest distance of a point from the centre [m]
};

/// The convex hull of one or more points [m]. Allocates.
[[nodiscard]] ConvexPiece convex_piece(std::span<const Point> points);

/// Triangles that cover a simple polygon with these corners, in either order. Empty for a polygon without area.
[[nodiscard]] std::vector<ConvexPiece> triangles(std::span<const Point> corners);

}  // namespace hecaton::planner::cspace
