#include "planner/global/convex_pieces.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner::global {
namespace {

using Loop = std::vector<Eigen::Vector3d>;

/// Newell's normal: of loops with corners on one line, too. Not unit.
Eigen::Vector3d newell_normal(const Loop& loop) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    normal += (loop[i] - loop[0]).cross(loop[(i + 1) % loop.size()] - loop[0]);
  }
  return normal;
}

void order_around(Loop& loop, const Eigen::Vector3d& normal) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& p : loop) centre += p / static_cast<double>(loop.size());
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  const auto angle = [&](const Eigen::Vector3d& p) { return std::atan2(v.dot(p - centre), u.dot(p - centre)); };
  std::sort(loop.begin(), loop.end(), [&](const auto& a, const auto& b) { return angle(a) < angle(b); });
}

}  // namespace

std::vector<Eigen::Vector3d> ConvexPolyhedron::corners() const {
  std::vector<Eigen::Vector3d> all;
  for (const auto& face : faces) all.insert(all.end(), face.begin(), face.end());
  return all;
}

ConvexPolyhedron polyhedron_of(const world::Box& box) {
  ConvexPolyhedron result;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      Loop face;
      for (const auto& [a, b] : {std::pair{-1.0, -1.0}, {side, -side}, {1.0, 1.0}, {-side, side}}) {
        Eigen::Vector3d corner;
        corner[axis] = side * box.half_extents[axis];
        corner[u] = a * box.half_extents[u];
        corner[v] = b * box.half_extents[v];
        face.push_back(corner);
      }
      result.faces.push_back(std::move(face));
    }
  }
  return result;
}

ConvexPolyhedron polyhedron_of(const world::ConvexHull& hull) {
  ConvexPolyhedron result;
  for (const auto& face : hull.faces) {
    Loop& loop = result.faces.emplace_back();
    for (const int vertex : face) loop.push_back(hull.vertices[vertex]);
  }
  return result;
}

std::vector<HalfSpace> half_spaces(const ConvexPolyhedron& polyhedron) {
  Eigen::Vector3d inside = Eigen::Vector3d::Zero();
  const Loop corners = polyhedron.corners();
  for (const auto& p : corners) inside += p / static_cast<double>(corners.size());
  std::vector<HalfSpace> result;
  for (const auto& face : polyhedron.faces) {
    Eigen::Vector3d normal = newell_normal(face);
    if (normal.norm() < 1e-14) continue;
    normal.normalize();
    if (normal.dot(face[0] - inside) < 0.0) normal = -normal;
    double offset = normal.dot(face[0]);
    for (const auto& p : corners) offset = std::max(offset, normal.dot(p));  // rounding: no corner is left outside
    const bool known = std::any_of(result.begin(), result.end(), [&](const HalfSpace& other) {
      return (other.normal - normal).norm() < 1e-9 && std::abs(other.offset - offset) < 1e-9;
    });
    if (!known) result.push_back({normal, offset});
  }
  return result;
}

ConvexPolyhedron cut(const ConvexPolyhedron& polyhedron, const HalfSpace& half) {
  ConvexPolyhedron result;
  Loop opening;
  const auto over = [&](const Eigen::Vector3d& p) { return half.normal.dot(p) - half.offset; };
  for (const Loop& face : polyhedron.faces) {
    Loop kept;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Eigen::Vector3d& p = face[i];
      const Eigen::Vector3d& q = face[(i + 1) % face.size()];
      const double over_p = over(p);
      const double over_q = over(q);
      if (over_p <= 0.0) kept.push_back(p);
      if ((over_p < 0.0 && over_q > 0.0) || (over_p > 0.0 && over_q < 0.0)) {
        kept.push_back(p + (over_p / (over_p - over_q)) * (q - p));
        opening.push_back(kept.back());
      }
    }
    if (kept.size() >= 3) result.faces.push_back(std::move(kept));
  }
  if (opening.size() >= 3) {
    order_around(opening, half.normal);
    result.faces.push_back(std::move(opening));
  }
  return result;
}

}  // namespace hecaton::planner::global
