#pragma once
/// Bullet's opinion on the signed distance of two shapes: an implementation that shares no line with ours.

#include <optional>

#include "planner/collision/clearance.hpp"
#include "world/model/shape.hpp"

namespace hecaton::test {

/// By btGjkPairDetector with EPA for penetration, in double precision and without collision margins. Nothing when
/// Bullet gives up.
[[nodiscard]] std::optional<planner::ShapeDistance> bullet_distance(const world::Shape& a, const world::Pose& X_WA,
                                                                    const world::Shape& b, const world::Pose& X_WB);

}  // namespace hecaton::test
