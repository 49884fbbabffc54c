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

}  // namespace hecaton::planner
