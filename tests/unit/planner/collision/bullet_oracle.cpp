#include "bullet_oracle.hpp"

#include <memory>
#include <stdexcept>
#include <string>

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

namespace hecaton::test {
namespace {

btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
Eigen::Vector3d from_bullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

btTransform to_bullet(const world::Pose& X) {
  btMatrix3x3 R;
  for (int row = 0; row < 3; ++row) R[row] = to_bullet(Eigen::Vector3d(X.linear().row(row)));
  return btTransform(R, to_bullet(Eigen::Vector3d(X.translation())));
}

std::unique_ptr<btConvexShape> to_bullet(const world::Shape& shape) {
  struct Visitor {
    std::unique_ptr<btConvexShape> operator()(const world::Box& box) const {
      return std::make_unique<btBoxShape>(to_bullet(box.half_extents));
    }
    std::unique_ptr<btConvexShape> operator()(const world::Sphere& sphere) const {
      return std::make_unique<btSphereShape>(sphere.radius);
    }
    std::unique_ptr<btConvexShape> operator()(const world::Capsule& capsule) const {
      return std::make_unique<btCapsuleShapeZ>(capsule.radius, 2.0 * capsule.half_length);
    }
    std::unique_ptr<btConvexShape> operator()(const world::Cylinder& cylinder) const {
      return std::make_unique<btCylinderShapeZ>(btVector3(cylinder.radius, cylinder.radius, cylinder.half_length));
    }
    std::unique_ptr<btConvexShape> operator()(const world::Convex& convex) const {
      auto hull = std::make_unique<btConvexHullShape>();
      for (const auto& vertex : convex.hull->vertices) hull->addPoint(to_bullet(vertex));
      return hull;
    }
    std::unique_ptr<btConvexShape> operator()(const world::Points& points) const {
      throw std::logic_error("no convex shape: " + std::to_string(points.cloud->size()) + " points");
    }
  };
  auto converted = std::visit(Visitor{}, shape);
  // A sphere's and a capsule's margin is its radius; other margins would round edges.
  const bool is_round = std::holds_alternative<world::Sphere>(shape) || std::holds_alternative<world::Capsule>(shape);
  if (!is_round) converted->setMargin(0.0);
  return converted;
}

}  // namespace

std::optional<planner::ShapeDistance> bullet_distance(const world::Shape& a, const world::Pose& X_WA,
                                                      const world::Shape& b, const world::Pose& X_WB) {
  const auto shape_a = to_bullet(a);
  const auto shape_b = to_bullet(b);
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver epa;
  btGjkPairDetector detector(shape_a.get(), shape_b.get(), &simplex, &epa);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = to_bullet(X_WA);
  input.m_transformB = to_bullet(X_WB);
  btPointCollector found;
  detector.getClosestPoints(input, found, nullptr);
  if (!found.m_hasResult) return std::nullopt;
  planner::ShapeDistance result;
  result.distance = found.m_distance;
  result.n_W = -from_bullet(found.m_normalOnBInWorld);  // Bullet's normal points from b to a
  result.p_b_W = from_bullet(found.m_pointInWorld);
  result.p_a_W = result.p_b_W - result.distance * result.n_W;
  return result;
}

}  // namespace hecaton::test
