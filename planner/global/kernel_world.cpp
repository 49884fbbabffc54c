#include "planner/global/kernel_world.hpp"

#include <cmath>

#include "planner/global/convex_pieces.hpp"

namespace hecaton::planner::global {
namespace {

constexpr double kWorldRounding = 1e-6;
/// No body reaches this far: the side of boxes that nothing meets [m].
constexpr float kNowhere = 3e37F;

/// Half extents of the axis-parallel box around a shape at X_OS, and its centre.
struct Extent {
  Eigen::Vector3d centre;
  Eigen::Vector3d half;
};

Extent extent_of(const world::Shape& shape, const Pose& X_OS) {
  const Eigen::Matrix3d size = X_OS.linear().cwiseAbs();
  const Eigen::Vector3d z = size.col(2);
  struct Visitor {
    const Pose& X_OS;
    const Eigen::Matrix3d& size;
    const Eigen::Vector3d& z;
    Extent operator()(const world::Box& box) const { return {X_OS.translation(), size * box.half_extents}; }
    Extent operator()(const world::Sphere& sphere) const {
      return {X_OS.translation(), Eigen::Vector3d::Constant(sphere.radius)};
    }
    Extent operator()(const world::Capsule& capsule) const {
      return {X_OS.translation(), z * capsule.half_length + Eigen::Vector3d::Constant(capsule.radius)};
    }
    Extent operator()(const world::Cylinder& cylinder) const {
      const Eigen::Vector3d across = (Eigen::Vector3d::Ones() - z.cwiseProduct(z)).cwiseMax(0.0).cwiseSqrt();
      return {X_OS.translation(), z * cylinder.half_length + across * cylinder.radius};
    }
    Extent operator()(const world::Convex& convex) const {
      Eigen::AlignedBox3d box;
      for (const auto& vertex : convex.hull->vertices) box.extend(X_OS * vertex);
      return {box.center(), box.sizes() / 2.0};
    }
  };
  return std::visit(Visitor{X_OS, size, z}, shape);
}

struct ObstacleMaker {
  KernelWorld& world;
  const Pose& X_OS;
  double rounding;  ///< [m]
  KernelObstacle obstacle;

  void half(double x, double y, double z) {
    obstacle.half = {static_cast<float>(x + rounding), static_cast<float>(y + rounding),
                     static_cast<float>(z + rounding)};
  }
  void operator()(const world::Box& box) {
    obstacle.kind = ObstacleKind::kBox;
    half(box.half_extents.x(), box.half_extents.y(), box.half_extents.z());
  }
  void operator()(const world::Sphere& sphere) {
    obstacle.kind = ObstacleKind::kSphere;
    half(sphere.radius, 0.0, 0.0);
  }
  void operator()(const world::Capsule& capsule) {
    obstacle.kind = ObstacleKind::kCapsule;
    half(capsule.radius, 0.0, capsule.half_length);
  }
  void operator()(const world::Cylinder& cylinder) {
    obstacle.kind = ObstacleKind::kCylinder;
    half(cylinder.radius, 0.0, cylinder.half_length);
  }
  void operator()(const world::Convex& convex) {
    obstacle.kind = ObstacleKind::kConvex;
    obstacle.first = static_cast<int>(world.planes.size());
    for (const HalfSpace& face : half_spaces(polyhedron_of(*convex.hull))) {
      const Eigen::Vector3d normal = X_OS.linear() * face.normal;
      KernelPlane& plane = world.planes.emplace_back();
      for (int k = 0; k < 3; ++k) plane.normal[k] = static_cast<float>(normal[k]);
      plane.offset = static_cast<float>(face.offset + normal.dot(X_OS.translation()) + rounding);
    }
    obstacle.count = static_cast<int>(world.planes.size()) - obstacle.first;
  }
};

}  // namespace

KernelWorld kernel_world(std::span<const WorldBody> bodies, const Pose& X_OW) {
  KernelWorld world;
  for (const WorldBody& body : bodies) {
    const Pose X_OS = X_OW * body.X_WS;
    const Extent extent = extent_of(body.shape, X_OS);
    const double rounding = kWorldRounding * (extent.centre.cwiseAbs() + extent.half).maxCoeff();
    ObstacleMaker maker{world, X_OS, rounding, {}};
    for (int k = 0; k < 9; ++k) maker.obstacle.axes[k] = static_cast<float>(X_OS.linear()(k % 3, k / 3));
    for (int k = 0; k < 3; ++k) maker.obstacle.centre[k] = static_cast<float>(X_OS.translation()[k]);
    std::visit(maker, body.shape);
    const world::BoundingSphere ball = world::bounding_sphere(body.shape);
    const Eigen::Vector3d middle = X_OS * ball.centre;
    for (int k = 0; k < 3; ++k) maker.obstacle.middle[k] = static_cast<float>(middle[k]);
    maker.obstacle.reach = static_cast<float>(ball.radius + 4.0 * rounding);
    const std::size_t lane = world.obstacles.size() % kWidth;
    world.obstacles.push_back(maker.obstacle);
    if (lane == 0) {
      for (auto& side : world.boxes.emplace_back()) side.fill(kNowhere);
    }
    for (int k = 0; k < 3; ++k) {
      world.boxes.back()[k][lane] = static_cast<float>(extent.centre[k] - extent.half[k] - 2.0 * rounding);
      world.boxes.back()[k + 3][lane] = static_cast<float>(extent.centre[k] + extent.half[k] + 2.0 * rounding);
    }
  }
  return world;
}

}  // namespace hecaton::planner::global
