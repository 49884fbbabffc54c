#pragma once
/// Signed distances of shapes that were prepared once and are asked about often.

#include "planner/collision/shape_distance.hpp"
#include "planner/collision/swept_core.hpp"
#include "world/model/pose.hpp"

namespace hecaton::planner {

/// As shape_distance of the shapes that the cores were made of. Does not allocate.
[[nodiscard]] ShapeDistance prepared_distance(const SweptCore& a, const world::Pose& X_WA, const SweptCore& b,
                                              const world::Pose& X_WB);

}  // namespace hecaton::planner
