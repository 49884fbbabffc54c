#pragma once
/// The signed distance of two shapes by Bullet, an independent implementation.

#include <optional>

#include "planner/collision/clearance.hpp"
#include "world/model/shape.hpp"

namespace hecaton::test {

/// By btGjkPairDetector with EPA for penetration, in double precision and without collision margins. Empty when Bullet
/// fails.
[[nodiscard]] std::optional<planner::ShapeDistance> bullet_distance(const world::Shape& a, const world::Pose& X_WA,
                                                                    const world::Shape& b, const world::Pose& X_WB);

}  // namespace hecaton::test
