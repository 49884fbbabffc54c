#pragma once
/// Polyhedra with few vertices that enclose a hull with many.

#include "world/model/shape.hpp"

namespace hecaton::planner {

/// A convex polyhedron of at most `most_vertices` (≥ 8) vertices [m] that encloses `hull`: `hull` itself when it is
/// small enough, else the intersection of the half-spaces of some of its faces and of its bounding box.
[[nodiscard]] world::ConvexHull enclosing_hull(const world::ConvexHull& hull, int most_vertices);

}  // namespace hecaton::planner
