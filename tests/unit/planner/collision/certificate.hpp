#pragma once
/// Bounds of a signed distance without another distance algorithm: membership and support functions of the shapes.

#include <limits>

#include "planner/collision/clearance.hpp"
#include "world/model/shape.hpp"

namespace hecaton::test {

/// max n·x over the shape at X_WS.
inline double support(const world::Shape& shape, const world::Pose& X_WS, const Eigen::Vector3d& n_W) {
  const Eigen::Vector3d n = X_WS.linear().transpose() * n_W;
  const double around_z = std::hypot(n.x(), n.y());
  double local = 0.0;
  if (const auto* box = std::get_if<world::Box>(&shape)) {
    local = box->half_extents.dot(n.cwiseAbs());
  } else if (const auto* sphere = std::get_if<world::Sphere>(&shape)) {
    local = sphere->radius * n.norm();
  } else if (const auto* capsule = std::get_if<world::Capsule>(&shape)) {
    local = capsule->radius * n.norm() + capsule->half_length * std::abs(n.z());
  } else if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    local = cylinder->radius * around_z + cylinder->half_length * std::abs(n.z());
  } else {
    local = -std::numeric_limits<double>::infinity();
    for (const auto& vertex : std::get<world::Convex>(shape).hull->vertices) local = std::max(local, vertex.dot(n));
  }
  return local + X_WS.translation().dot(n_W);
}

/// The translation of b along n that separates it from a [m]: for every n an upper bound of the depth of penetration;
/// its negative is a lower bound of the distance.
inline double depth_along(const world::Shape& a, const world::Pose& X_WA, const world::Shape& b,
                          const world::Pose& X_WB, const Eigen::Vector3d& n_W) {
  return support(a, X_WA, n_W) + support(b, X_WB, -n_W);
}

/// A lower bound of the point's distance from the shape at X_WS [m]; ≤ 0 inside or on it.
inline double outside(const world::Shape& shape, const world::Pose& X_WS, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p = X_WS.inverse() * p_W;
  if (const auto* box = std::get_if<world::Box>(&shape)) return (p.cwiseAbs() - box->half_extents).maxCoeff();
  if (const auto* sphere = std::get_if<world::Sphere>(&shape)) return p.norm() - sphere->radius;
  if (const auto* capsule = std::get_if<world::Capsule>(&shape)) {
    const double beyond = std::max(std::abs(p.z()) - capsule->half_length, 0.0);
    return Eigen::Vector3d(p.x(), p.y(), beyond).norm() - capsule->radius;
  }
  if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    return std::max(std::hypot(p.x(), p.y()) - cylinder->radius, std::abs(p.z()) - cylinder->half_length);
  }
  const auto& hull = *std::get<world::Convex>(shape).hull;
  double most = -std::numeric_limits<double>::infinity();
  for (const auto& face : hull.faces) {
    const auto& origin = hull.vertices[face[0]];
    const Eigen::Vector3d normal =
        (hull.vertices[face[1]] - origin).cross(hull.vertices[face[2]] - origin).normalized();
    most = std::max(most, normal.dot(p - origin));
  }
  return most;
}

}  // namespace hecaton::test
