#pragma once
/// Signed distance of two convex cores by GJK, and by the expanding polytope where they overlap.

#include "planner/collision/shape_distance.hpp"
#include "planner/collision/swept_core.hpp"

namespace hecaton::planner {

/// Of the cores alone, without their balls. At least one of them must have a volume. Does not allocate.
/// Whatever rounding does to the algorithms, the answer is proved by its normal: the distance is what the two support
/// functions say along n, so it is never larger than the true one.
[[nodiscard]] ShapeDistance convex_distance(const SweptCore& a, const world::Pose& X_WA, const SweptCore& b,
                                            const world::Pose& X_WB);

/// What a thing covers that goes straight on for a while, and strays from that way ever farther: the hull of a ball of
/// radius `stray_first` around each of its points where it is and one of `stray_last` where it ends.
struct Sweep {
  Eigen::Vector3d way_W = Eigen::Vector3d::Zero();  ///< [m]
  double stray_first = 0.0;                         ///< [m], ≥ 0
  double stray_last = 0.0;                          ///< [m], ≥ stray_first
};

/// Of core a from all that core b sweeps. Where they overlap, and where they are too near to tell, the distance is 0
/// and the normal is none.
[[nodiscard]] ShapeDistance sweep_distance(const SweptCore& a, const world::Pose& X_WA, const SweptCore& b,
                                           const world::Pose& X_WB, const Sweep& sweep);

}  // namespace hecaton::planner
