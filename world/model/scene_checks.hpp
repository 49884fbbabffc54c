#pragma once
/// Checks of obstacles before the physics simulation takes them. why_invalid() returns nothing for valid input, else
/// one sentence: what is wrong and what is allowed.

#include <optional>
#include <string>

#include "world/model/scene.hpp"

namespace hecaton::world {

/// Sizes finite and > 0 (a capsule's half length may be 0), a hull with volume and with faces on its own vertices.
[[nodiscard]] std::optional<std::string> why_invalid(const Shape& shape);

/// True when the pose is finite and its rotation orthonormal and right-handed within 1e-6.
[[nodiscard]] bool is_rigid(const Pose& pose);

/// Checks name, shapes, poses and the motion's parameters, but not whether the name is unique.
[[nodiscard]] std::optional<std::string> why_invalid(const Obstacle& obstacle);

/// Volume [m³], > 0 for every valid shape; of a hull by its faces; of points that of all balls, overlaps included.
[[nodiscard]] double volume(const Shape& shape);

}  // namespace hecaton::world
