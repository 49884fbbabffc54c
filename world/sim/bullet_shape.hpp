#pragma once
/// Conversion of shapes and poses to Bullet, and exact distances. Collision margins change no shape.

#include <memory>

#include <btBulletCollisionCommon.h>

#include "world/model/pose.hpp"
#include "world/model/shape.hpp"

namespace hecaton::world {

[[nodiscard]] inline btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
[[nodiscard]] inline Eigen::Vector3d from_bullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
[[nodiscard]] btTransform to_bullet(const Pose& pose);
[[nodiscard]] Pose from_bullet(const btTransform& transform);

/// The convex shape in its frame S. A sphere and a capsule use Bullet's margin as their radius, which is exact; other
/// shapes have margin 0. Points become the box around them, which only bounds distances (world/sim/cloud_balls.hpp).
/// The shape must have passed why_invalid().
[[nodiscard]] std::unique_ptr<btConvexShape> make_bullet_shape(const Shape& shape);

/// Signed distance between two placed shapes.
struct SignedDistance {
  double distance = 0.0;         ///< [m]; negative: the penetration depth
  btVector3 n_W{0.0, 0.0, 1.0};  ///< unit, from b towards a
};

/// By Bullet's GJK, and EPA where the shapes overlap. The gap along the normal verifies each result within 0.1 mm. A
/// result that cannot be verified (2 in 10,000 random overlaps; cylinder to cylinder) errs towards the smaller
/// distance.
[[nodiscard]] SignedDistance signed_distance(const btConvexShape& a, const btTransform& X_WA, const btConvexShape& b,
                                             const btTransform& X_WB);

/// Gap between two shapes along the unit vector n, from b towards a [m]. A lower bound of the signed distance for every
/// n; equal to it for the normal of the closest points.
[[nodiscard]] double gap_along(const btVector3& n_W, const btConvexShape& a, const btTransform& X_WA,
                               const btConvexShape& b, const btTransform& X_WB);

}  // namespace hecaton::world
