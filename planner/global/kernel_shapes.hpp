#pragma once
/// Shapes as the collision kernel reads them: spheres that cover a link's shape, and obstacles as floats.

#include <span>
#include <string>
#include <vector>

#include "planner/global/validity_kernel.hpp"
#include "world/model/shape.hpp"

namespace hecaton::planner::global {

struct CoverOptions {
  double excess = 0.004;  ///< the cover exceeds the shape by at most this, if max_spheres allow it [m]
  int max_spheres = 48;   ///< for one shape
};

/// Spheres, in the shape's frame S, that together contain the shape. Closed form for a sphere, capsule and cylinder;
/// other shapes are cut in half where the sphere of a piece exceeds the shape the most.
[[nodiscard]] std::vector<world::BoundingSphere> sphere_cover(const world::Shape& shape, const CoverOptions& options);

/// A sphere that contains the points [m], at most a few per cent larger than the smallest one.
[[nodiscard]] world::BoundingSphere bounding_sphere_of(const std::vector<Eigen::Vector3d>& points);

/// A fixed body that the robot must avoid.
struct WorldBody {
  world::Shape shape;
  world::Pose X_WS = world::Pose::Identity();
  std::string name;  ///< for messages
};

/// The bodies in frame O, enlarged by the error of rounding to floats, with `padding`. `reach_of_link`: balls in O that
/// contain the links in all configurations. Refers to the clouds of `bodies`.
[[nodiscard]] KernelWorld kernel_world(std::span<const WorldBody> bodies, const world::Pose& X_OW, double padding,
                                       std::span<const world::BoundingSphere> reach_of_link);

}  // namespace hecaton::planner::global
