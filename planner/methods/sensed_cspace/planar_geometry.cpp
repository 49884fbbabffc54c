#include "planner/methods/sensed_cspace/planar_geometry.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner::cspace {
namespace {

/// Twice the area of the triangle; positive: counter-clockwise.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Andrew's monotone chain: counter-clockwise, without points that lie on an edge.
std::vector<Point> hull(std::span<const Point> points) {
  std::vector<Point> sorted(points.begin(), points.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const Point& a, const Point& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  sorted.erase(std::unique(sorted.begin(), sorted.end(),
                           [](const Point& a, const Point& b) { return a.x == b.x && a.y == b.y; }),
               sorted.end());
  if (sorted.size() < 3) return sorted;
  std::vector<Point> corners;
  const auto add = [&](const Point& point, std::size_t fixed) {
    while (corners.size() > fixed && turn(corners[corners.size() - 2], corners.back(), point) <= 0.0)
      corners.pop_back();
    corners.push_back(point);
  };
  for (const Point& point : sorted) add(point, 1);
  const std::size_t lower = corners.size();
  for (auto point = sorted.rbegin() + 1; point != sorted.rend(); ++point) add(*point, lower);
  corners.pop_back();
  return corners;
}

Edge edge_between(const Point& from, const Point& to) {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const Point along{(to.x - from.x) / length, (to.y - from.y) / length};
  return {from, along, {along.y, -along.x}, length};
}

bool inside(const Point& p, const Point& a, const Point& b, const Point& c) {
  return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
}

}  // namespace

ConvexPiece convex_piece(std::span<const Point> points) {
  ConvexPiece piece{hull(points), {}, {}, 0.0};
  const std::vector<Point>& corners = piece.corners;
  const auto count = static_cast<double>(corners.size());
  for (const Point& corner : corners) {
    piece.centre.x += corner.x / count;
    piece.centre.y += corner.y / count;
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    piece.radius = std::max(piece.radius, std::hypot(corners[i].x - piece.centre.x, corners[i].y - piece.centre.y));
    if (corners.size() > 1) piece.edges.push_back(edge_between(corners[i], corners[(i + 1) % corners.size()]));
  }
  return piece;
}

// Ear clipping: there is always a corner that forms an empty triangle with its neighbours.
std::vector<ConvexPiece> triangles(std::span<const Point> corners) {
  std::vector<Point> left(corners.begin(), corners.end());
  double area = 0.0;
  for (std::size_t i = 0; i + 1 < left.size(); ++i) area += turn(left[0], left[i], left[i + 1]);
  if (area < 0.0) std::reverse(left.begin(), left.end());
  std::vector<ConvexPiece> pieces;
  while (left.size() >= 3) {
    bool cut = false;
    for (std::size_t i = 0; i < left.size() && !cut; ++i) {
      const std::size_t before = (i + left.size() - 1) % left.size();
      const std::size_t after = (i + 1) % left.size();
      const Point triangle[] = {left[before], left[i], left[after]};
      const double area_of_ear = turn(triangle[0], triangle[1], triangle[2]);
      if (area_of_ear < 0.0) continue;
      bool empty = true;
      for (std::size_t k = 0; k < left.size(); ++k) {
        if (k == before || k == i || k == after) continue;
        empty = empty && !inside(left[k], triangle[0], triangle[1], triangle[2]);
      }
      if (!empty && area_of_ear > 0.0) continue;
      if (area_of_ear > 0.0) pieces.push_back(convex_piece(triangle));
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      cut = true;
    }
    if (!cut) break;  // it crosses itself
  }
  return pieces;
}

}  // namespace hecaton::planner::cspace
