#pragma once
/// The C-space image of an obstacle by brute force: the distance of the arm from the obstacle in the centre of each
/// cell. Shares only types with planner/methods/sensed_cspace.

#include <algorithm>
#include <cmath>
#include <vector>

#include "planner/local/random.hpp"
#include "planner/methods/sensed_cspace/cspace_map.hpp"
#include "planner/methods/sensed_cspace/planar_geometry.hpp"

namespace hecaton::test {

using planner::cspace::Point;

class BruteForce {
 public:
  BruteForce(const planner::cspace::PlanarArm& arm, planner::cspace::AngleGrid grid) : arm_(arm), grid_(grid) {}

  /// A polygon in either order (1 corner: a point, 2: a segment).
  [[nodiscard]] planner::cspace::CspaceMap map(const std::vector<Point>& polygon) const {
    planner::cspace::CspaceMap map(grid_);
    for (int row = 0; row < grid_.cells; ++row) {
      const double theta1 = grid_.centre(row);
      const Point elbow{arm_.length1 * std::cos(theta1), arm_.length1 * std::sin(theta1)};
      const bool first_link = distance({0.0, 0.0}, elbow, polygon) <= arm_.width1;
      if (!first_link && distance(elbow, elbow, polygon) > arm_.length2 + arm_.width2) continue;
      for (int column = 0; column < grid_.cells; ++column) {
        const double direction = theta1 + grid_.centre(column);
        const Point tip{elbow.x + arm_.length2 * std::cos(direction), elbow.y + arm_.length2 * std::sin(direction)};
        if (first_link || distance(elbow, tip, polygon) <= arm_.width2) {
          map.block(row, {static_cast<std::int16_t>(column), 1});
        }
      }
    }
    return map;
  }

  /// Distance of a segment and a polygon; 0 if they overlap.
  [[nodiscard]] static double distance(const Point& a, const Point& b, const std::vector<Point>& polygon) {
    if (contains(polygon, a)) return 0.0;
    double least = 1e300;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point& c = polygon[i];
      const Point& d = polygon[(i + 1) % polygon.size()];
      if (cross_each_other(a, b, c, d)) return 0.0;
      least = std::min({least, to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)});
    }
    return least;
  }

 private:
  static double side(const Point& a, const Point& b, const Point& p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
  }
  static bool cross_each_other(const Point& a, const Point& b, const Point& c, const Point& d) {
    return side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
  }
  static double to_segment(const Point& p, const Point& a, const Point& b) {
    const double x = b.x - a.x;
    const double y = b.y - a.y;
    const double length2 = x * x + y * y;
    const double t = length2 > 0.0 ? std::clamp(((p.x - a.x) * x + (p.y - a.y) * y) / length2, 0.0, 1.0) : 0.0;
    return std::hypot(p.x - a.x - t * x, p.y - a.y - t * y);
  }
  /// Point in polygon, by counting crossings.
  static bool contains(const std::vector<Point>& polygon, const Point& p) {
    bool in = false;
    for (std::size_t i = 0, k = polygon.size() - 1; i < polygon.size(); k = i++) {
      const Point& a = polygon[i];
      const Point& b = polygon[k];
      if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) in = !in;
    }
    return in;
  }

  planner::cspace::PlanarArm arm_;
  planner::cspace::AngleGrid grid_;
};

/// Corners of a random convex polygon (or segment, or point) of 0.025 to 0.3 link lengths, within the arm's reach and
/// clear of its base.
inline std::vector<Point> random_convex(planner::Random& random, const planner::cspace::PlanarArm& arm) {
  for (;;) {
    const double unit = arm.reach() / 40.0;
    const double r = random.uniform(0.0, arm.reach());
    const double phi = random.uniform(-planner::cspace::kPi, planner::cspace::kPi);
    const double long_axis = random.uniform(0.5, 6.0) * unit;
    const double short_axis = long_axis * random.uniform(0.2, 1.0);
    const double turn = random.uniform(0.0, planner::cspace::kPi);
    const int count = 1 + static_cast<int>(random.next() % 12);
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
      const double angle = random.uniform(-planner::cspace::kPi, planner::cspace::kPi);
      const double x = long_axis * std::cos(angle);
      const double y = short_axis * std::sin(angle);
      points.push_back({r * std::cos(phi) + x * std::cos(turn) - y * std::sin(turn),
                        r * std::sin(phi) + x * std::sin(turn) + y * std::cos(turn)});
    }
    std::vector<Point> corners = planner::cspace::convex_piece(points).corners;
    if (BruteForce::distance({0.0, 0.0}, {0.0, 0.0}, corners) > arm.width1 + 0.5 * unit) return corners;
  }
}

}  // namespace hecaton::test
