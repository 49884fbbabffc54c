#pragma once
/// Convex hulls of point sets in three dimensions, and smaller polyhedra around them. Points in metres, in any frame;
/// results in the same frame.

#include <optional>
#include <span>

#include "world/model/shape.hpp"

namespace hecaton::planner {

/// The hull of `points` [Barber96]: faces are polygons, all vertices are among the points. A point lies outside it by
/// at most 1e-11 of the set's extent. Empty when a point is not finite, or when the set is thinner than 1e-6 of its
/// extent.
[[nodiscard]] std::optional<world::ConvexHull> convex_hull(std::span<const Eigen::Vector3d> points);

/// Volume [m³] of a closed polyhedron with outward faces.
[[nodiscard]] double volume(const world::ConvexHull& hull);

/// The half-space n·p ≤ offset whose boundary contains a face.
struct FacePlane {
  Eigen::Vector3d normal;  ///< unit, outward
  double offset;           ///< [m]
};
[[nodiscard]] FacePlane face_plane(const world::ConvexHull& hull, int face);

/// A convex polyhedron of at most `most_vertices` (≥ 8) vertices that encloses `hull`: `hull` itself when it has no
/// more, else the intersection of half-spaces of some of its faces and of its bounding box.
[[nodiscard]] world::ConvexHull enclosing_hull(const world::ConvexHull& hull, int most_vertices);

/// Shapes keep at most this many vertices: more cost time in every distance and gain less than a millimetre.
inline constexpr int kMaxHullVertices = 64;

/// The hull of `points` as a shape; if it has more than kMaxHullVertices vertices, a polyhedron of so many that
/// encloses it. Throws std::invalid_argument with a sentence where convex_hull() is empty.
[[nodiscard]] world::Convex convex_shape(std::span<const Eigen::Vector3d> points);

}  // namespace hecaton::planner
