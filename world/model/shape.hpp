#pragma once
/// Collision shapes, each in its own frame S, centred on the origin of S unless said otherwise.

#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>
#include <vector>

#include "world/model/point_cloud.hpp"
#include "world/model/pose.hpp"

namespace hecaton::world {

/// A cuboid.
struct Box {
  Eigen::Vector3d half_extents;  ///< [m], each > 0
};

/// A ball.
struct Sphere {
  double radius;  ///< [m], > 0
};

/// All points within `radius` of the segment from (0, 0, −half_length) to (0, 0, +half_length).
struct Capsule {
  double radius;       ///< [m], > 0
  double half_length;  ///< of the segment, without the caps [m], ≥ 0
};

/// Axis along z.
struct Cylinder {
  double radius;       ///< [m], > 0
  double half_length;  ///< half of the height [m], > 0
};

/// A convex polyhedron. Shared, because a mesh's hull is the same for every copy of its robot.
struct ConvexHull {
  std::vector<Eigen::Vector3d> vertices;  ///< [m], in S; at least 4, not coplanar
  std::vector<std::vector<int>> faces;    ///< vertex indices, counter-clockwise from outside
};
/// A convex hull, placed in its frame S.
struct Convex {
  std::shared_ptr<const ConvexHull> hull;  ///< never null
};

/// Balls of one radius about points. The only shape that is not convex: a body of it stands or moves with an obstacle,
/// but no arm carries it, and it does not fall.
struct Points {
  std::shared_ptr<const PointCloud> cloud;  ///< never null
};

/// Shape of a body.
using Shape = std::variant<Box, Sphere, Capsule, Cylinder, Convex, Points>;

/// A shape fixed to a body B.
struct PlacedShape {
  Shape shape;                   ///< in S
  Pose X_BS = Pose::Identity();  ///< of S in B
};

/// A ball that encloses the shape, in the shape's frame S.
struct BoundingSphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< [m]
  double radius = 0.0;                               ///< [m]
};

/// A ball around the shape; of a hull not the smallest one.
inline BoundingSphere bounding_sphere(const Shape& shape) {
  struct Visitor {
    BoundingSphere operator()(const Box& box) const { return {Eigen::Vector3d::Zero(), box.half_extents.norm()}; }
    BoundingSphere operator()(const Sphere& sphere) const { return {Eigen::Vector3d::Zero(), sphere.radius}; }
    BoundingSphere operator()(const Capsule& capsule) const {
      return {Eigen::Vector3d::Zero(), capsule.half_length + capsule.radius};
    }
    BoundingSphere operator()(const Cylinder& cylinder) const {
      return {Eigen::Vector3d::Zero(), std::hypot(cylinder.half_length, cylinder.radius)};
    }
    BoundingSphere operator()(const Convex& convex) const {
      const auto& vertices = convex.hull->vertices;
      Eigen::AlignedBox3d box;
      for (const auto& vertex : vertices) box.extend(vertex);
      BoundingSphere ball{box.center(), 0.0};
      for (const auto& vertex : vertices) ball.radius = std::max(ball.radius, (vertex - ball.centre).norm());
      return ball;
    }
    BoundingSphere operator()(const Points& points) const {
      return {points.cloud->centre(), points.cloud->bounding_radius()};
    }
  };
  return std::visit(Visitor{}, shape);
}

}  // namespace hecaton::world
