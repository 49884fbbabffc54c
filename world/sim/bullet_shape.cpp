#include "world/sim/bullet_shape.hpp"

#include <algorithm>
#include <array>

#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

namespace hecaton::world {
namespace {

struct ShapeMaker {
  using Made = std::unique_ptr<btConvexShape>;

  Made operator()(const Box& box) const {
    return without_margin(std::make_unique<btBoxShape>(to_bullet(box.half_extents)));
  }
  Made operator()(const Sphere& sphere) const { return std::make_unique<btSphereShape>(sphere.radius); }
  Made operator()(const Capsule& capsule) const {
    // Bullet's height is the length of the segment, without the caps. The plain btCapsuleShape lies along y.
    return std::make_unique<btCapsuleShapeZ>(capsule.radius, 2.0 * capsule.half_length);
  }
  Made operator()(const Cylinder& cylinder) const {
    return without_margin(
        std::make_unique<btCylinderShapeZ>(btVector3(cylinder.radius, cylinder.radius, cylinder.half_length)));
  }
  Made operator()(const Convex& convex) const {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Eigen::Vector3d& vertex : convex.hull->vertices) hull->addPoint(to_bullet(vertex), false);
    hull->recalcLocalAabb();
    return without_margin(std::move(hull));
  }
  Made operator()(const Points& points) const {
    auto hull = std::make_unique<btConvexHullShape>();
    const PointBox& box = points.cloud->box();
    const double radius = points.cloud->radius();
    for (int corner = 0; corner < 8; ++corner) {
      btVector3 p;
      for (int axis = 0; axis < 3; ++axis) {
        p[axis] = (corner >> axis & 1) != 0 ? static_cast<double>(box.high[axis]) + radius
                                            : static_cast<double>(box.low[axis]) - radius;
      }
      hull->addPoint(p, false);
    }
    hull->recalcLocalAabb();
    return without_margin(std::move(hull));
  }

  static Made without_margin(Made shape) {
    shape->setMargin(0.0);
    return shape;
  }
};

struct GjkResult final : btDiscreteCollisionDetectorInterface::Result {
  bool found = false;
  double distance = 0.0;
  btVector3 n_W{0.0, 0.0, 1.0};  ///< unit, from b towards a

  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3& normal_W, const btVector3&, btScalar depth) override {
    found = true;
    distance = depth;
    n_W = normal_W;
  }
};

GjkResult run_gjk(const btConvexShape& a, const btTransform& X_WA, const btConvexShape& b, const btTransform& X_WB) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver penetration;
  btGjkPairDetector detector(&a, &b, &simplex, &penetration);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = X_WA;
  input.m_transformB = X_WB;
  GjkResult result;
  detector.getClosestPoints(input, result, nullptr);
  return result;
}

/// A displacement of a few µm and µrad, different for each attempt.
btTransform nudged(const btTransform& X, int attempt) {
  static const std::array<btVector3, 6> axes = {btVector3(0.3, -0.5, 0.8),  btVector3(-0.7, 0.2, 0.6),
                                                btVector3(0.1, 0.9, 0.3),   btVector3(0.8, 0.3, -0.5),
                                                btVector3(-0.4, -0.6, 0.7), btVector3(0.5, 0.8, 0.1)};
  const double size = 1e-6 * (attempt + 1);
  const btVector3& axis = axes[attempt];
  return btTransform(btQuaternion(axis.normalized(), size) * X.getRotation(),
                     X.getOrigin() + size * btVector3(axis.y(), axis.z(), axis.x()));
}

constexpr int kAttempts = 6;
constexpr double kVerified = 1e-4;  // [m]

}  // namespace

btTransform to_bullet(const Pose& pose) {
  const auto& R = pose.linear();
  return btTransform(btMatrix3x3(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
                     to_bullet(pose.translation()));
}

Pose from_bullet(const btTransform& transform) {
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) pose.linear()(row, column) = transform.getBasis()[row][column];
  }
  pose.translation() = from_bullet(transform.getOrigin());
  return pose;
}

std::unique_ptr<btConvexShape> make_bullet_shape(const Shape& shape) {
  return std::visit(ShapeMaker{}, shape);
}

double gap_along(const btVector3& n_W, const btConvexShape& a, const btTransform& X_WA, const btConvexShape& b,
                 const btTransform& X_WB) {
  const btVector3 p_a = X_WA(a.localGetSupportingVertex(-n_W * X_WA.getBasis()));
  const btVector3 p_b = X_WB(b.localGetSupportingVertex(n_W * X_WB.getBasis()));
  return n_W.dot(p_a - p_b);
}

SignedDistance signed_distance(const btConvexShape& a, const btTransform& X_WA, const btConvexShape& b,
                               const btTransform& X_WB) {
  const GjkResult first = run_gjk(a, X_WA, b, X_WB);
  SignedDistance best{-BT_LARGE_FLOAT, first.n_W};
  if (first.found) best.distance = gap_along(first.n_W, a, X_WA, b, X_WB);
  if (first.found && first.distance - best.distance <= kVerified) return {first.distance, first.n_W};

  // For about one in 200 overlapping pairs that are exactly aligned, Bullet's EPA is wrong by centimetres. A small
  // displacement breaks the symmetry. Without a verified result the largest gap found is the answer.
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const GjkResult result = run_gjk(a, X_WA, b, nudged(X_WB, attempt));
    if (!result.found) continue;
    const double gap = gap_along(result.n_W, a, X_WA, b, X_WB);
    if (gap > best.distance) best = {gap, result.n_W};
    if (result.distance - gap <= kVerified) break;
  }
  // No result at all: the shapes are so close to touching that both algorithms fail. That counts as contact.
  if (best.distance == -BT_LARGE_FLOAT) best.distance = 0.0;
  return best;
}

}  // namespace hecaton::world
