#pragma once
/// A shape as a core and a ball that is swept along it: a sphere is a swept point, a capsule a swept segment, the
/// others are their own cores. Radii stay out of the iterative algorithms, so that touching and overlapping spheres and
/// capsules are no special case for them.

#include <cmath>
#include <cstdint>

#include "planner/collision/hull_vertices.hpp"
#include "world/model/shape.hpp"

namespace hecaton::planner {

enum class Core : std::uint8_t { kPoint, kSegment, kBox, kCylinder, kHull };

struct SweptCore {
  Core core = Core::kPoint;
  double radius = 0.0;                               ///< of the ball [m]
  Eigen::Vector3d half = Eigen::Vector3d::Zero();    ///< half extents along the axes of S [m]; zero for a hull
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< an inner point in S [m]
  HullVertices hull;                                 ///< of a hull only
};

[[nodiscard]] SweptCore make_swept_core(const world::Shape& shape);

/// A point of the core (without the ball) that is farthest along n, both in S.
[[nodiscard]] inline Eigen::Vector3d farthest(const SweptCore& core, const Eigen::Vector3d& n) {
  switch (core.core) {
    case Core::kPoint:
      break;
    case Core::kSegment:
      return {0.0, 0.0, std::copysign(core.half.z(), n.z())};
    case Core::kBox:
      return {std::copysign(core.half.x(), n.x()), std::copysign(core.half.y(), n.y()),
              std::copysign(core.half.z(), n.z())};
    case Core::kCylinder: {
      const double across = std::sqrt(n.x() * n.x() + n.y() * n.y());
      const double scale = across > 0.0 ? core.half.x() / across : 0.0;
      return {scale * n.x(), scale * n.y(), std::copysign(core.half.z(), n.z())};
    }
    case Core::kHull:
      return core.hull.farthest(n);
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace hecaton::planner
