#pragma once
/// A convex polyhedron as its faces' corners, to be cut by planes.

#include <vector>

#include "world/model/shape.hpp"

namespace hecaton::planner::global {

struct ConvexPolyhedron {
  std::vector<std::vector<Eigen::Vector3d>> faces;  ///< corners in order around each [m]

  [[nodiscard]] std::vector<Eigen::Vector3d> corners() const;  ///< each as often as faces meet there
};

/// n · x ≤ offset
struct HalfSpace {
  Eigen::Vector3d normal;  ///< unit
  double offset;           ///< [m]
};

[[nodiscard]] ConvexPolyhedron polyhedron_of(const world::Box& box);
[[nodiscard]] ConvexPolyhedron polyhedron_of(const world::ConvexHull& hull);

/// The half spaces whose intersection it is.
[[nodiscard]] std::vector<HalfSpace> half_spaces(const ConvexPolyhedron& polyhedron);

/// What of it lies in the half space; no faces when nothing does. The new face's corners are only as well ordered as
/// enclosing balls need.
[[nodiscard]] ConvexPolyhedron cut(const ConvexPolyhedron& polyhedron, const HalfSpace& half);

}  // namespace hecaton::planner::global
