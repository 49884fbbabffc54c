#pragma once
/// Signed distance of two convex cores by GJK, and by the expanding polytope where they overlap.

#include "planner/collision/clearance.hpp"
#include "planner/collision/swept_core.hpp"

namespace hecaton::planner {

/// The distance of the cores without their balls; at least one core must have a volume. The two support functions along
/// the normal prove the result: the distance never exceeds the true one, whatever the rounding. Does not allocate.
[[nodiscard]] ShapeDistance convex_distance(const SweptCore& a, const world::Pose& X_WA, const SweptCore& b,
                                            const world::Pose& X_WB);

/// The volume that a body sweeps on a straight way, with a position uncertainty that grows. It is the hull of balls
/// around all points of the body, of radius `radius_begin` at the beginning and `radius_end` at the end of the way.
struct Sweep {
  Eigen::Vector3d way_W = Eigen::Vector3d::Zero();  ///< [m]
  double radius_begin = 0.0;                        ///< [m], ≥ 0
  double radius_end = 0.0;                          ///< [m], ≥ radius_begin
};

/// The distance of core a from the volume that core b sweeps. When they overlap, or are too near to tell, the distance
/// is 0 and the normal undefined.
[[nodiscard]] ShapeDistance sweep_distance(const SweptCore& a, const world::Pose& X_WA, const SweptCore& b,
                                           const world::Pose& X_WB, const Sweep& sweep);

}  // namespace hecaton::planner
