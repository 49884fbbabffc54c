#pragma once
/// A shape as a core and a ball that is swept along it. A sphere is a swept point, a capsule a swept segment; other
/// shapes are their own cores. Radii stay out of the iterative algorithms, so that touching and overlapping spheres and
/// capsules are no special case.

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "world/model/shape.hpp"

namespace hecaton::planner {

/// Vertices of a convex polyhedron with their support function, which GJK evaluates thousands of times per pass. It
/// compares all vertices, four at a time, and needs no adjacency. For the few dozen vertices of a link's hull this is
/// faster than a walk along edges. The result is the same with and without AVX2.
class HullVertices {
 public:
  HullVertices() = default;
  explicit HullVertices(std::span<const Eigen::Vector3d> vertices);

  /// The vertex [m] with the greatest n·v; among equals the first in the order of four interleaved lists. There must be
  /// a vertex.
  [[nodiscard]] Eigen::Vector3d farthest(const Eigen::Vector3d& n) const;

 private:
  std::vector<double> x_;  // padded to whole groups of four with copies of the first vertex
  std::vector<double> y_;
  std::vector<double> z_;
};

enum class Core : std::uint8_t { kPoint, kSegment, kBox, kCylinder, kHull };

/// Geometry in the shape's frame S.
struct SweptCore {
  Core core = Core::kPoint;
  double radius = 0.0;                               ///< of the ball [m]
  Eigen::Vector3d half = Eigen::Vector3d::Zero();    ///< half extents along the axes of S [m]; zero for a hull
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< an inner point in S [m]
  HullVertices hull;                                 ///< of a hull only
};

/// Throws std::logic_error for points, which have no convex core (cloud_distance.hpp).
[[nodiscard]] SweptCore make_swept_core(const world::Shape& shape);

/// Support function: a point of the core, without the ball, that is farthest along n. Both in S.
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
