#pragma once
/// Capsules in URDFs: the format has none, so they are written as a cylinder with a ball at either end.

#include <vector>

#include "world/model/shape.hpp"

namespace hecaton::planner {

/// Replaces every cylinder that has two spheres of its radius at the centres of its ends by one capsule (all within
/// 10 µm); other shapes stay as they are, and as they are ordered.
[[nodiscard]] std::vector<world::PlacedShape> merge_capsules(const std::vector<world::PlacedShape>& shapes);

}  // namespace hecaton::planner
