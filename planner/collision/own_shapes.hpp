#pragma once
/// Distances of bodies with their own shapes where the distance pass uses capsules.

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/clearance.hpp"
#include "planner/collision/pass_input.hpp"

namespace hecaton::planner {

/// Distance of the two bodies of a clearance with their own shapes [m]; negative: depth of penetration. Precondition:
/// ExactDistance::clearances found it for this geometry at these poses. Allocates for convex hulls.
[[nodiscard]] double distance_of_own_shapes(const CellGeometry& geometry, const CellPoses& poses,
                                            const Clearance& clearance);

}  // namespace hecaton::planner
