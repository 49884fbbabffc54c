#pragma once
/// Whether an obstacle can exist at all, before physics sees it. Each answer is empty (yes) or one sentence that says
/// what is wrong and what is allowed.

#include <string>

#include "world/model/scene.hpp"

namespace hecaton::world {

/// Sizes finite and > 0 (a capsule's half length may be 0), a hull with volume and with faces on its own vertices.
[[nodiscard]] std::string why_invalid(const Shape& shape);

/// Finite, and its rotation orthonormal and right-handed within 1e-6.
[[nodiscard]] bool is_rigid(const Pose& pose);

/// Name, shapes, poses, and the motion's own parameters. Names are not compared with others.
[[nodiscard]] std::string why_invalid(const Obstacle& obstacle);

/// [m³], > 0 for every valid shape; a hull's from its faces.
[[nodiscard]] double volume(const Shape& shape);

}  // namespace hecaton::world
