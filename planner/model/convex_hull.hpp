#pragma once
/// Convex hulls of point sets in three dimensions. Points in metres, any frame; results in the same frame.

#include <optional>
#include <span>

#include "world/model/shape.hpp"

namespace hecaton::planner {

/// The hull of `points`; faces are polygons, all vertices are among the points. Points may lie outside it by no more
/// than 1e-11 of the set's extent. Nothing when the points are not finite or thinner than 1e-6 of their extent (no
/// volume).
[[nodiscard]] std::optional<world::ConvexHull> convex_hull(std::span<const Eigen::Vector3d> points);

/// Volume [m³] of a closed polyhedron with outward faces.
[[nodiscard]] double volume(const world::ConvexHull& hull);

/// The half-space n·p ≤ offset on whose border a face lies.
struct FacePlane {
  Eigen::Vector3d normal;  ///< unit, outward
  double offset;           ///< [m]
};
[[nodiscard]] FacePlane face_plane(const world::ConvexHull& hull, int face);

}  // namespace hecaton::planner
