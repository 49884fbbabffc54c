#pragma once
/// The capsule that stands for a link's collision shape where speed matters more than the last millimetre.

#include <optional>

#include "planner/model/enclosing_capsule.hpp"

namespace hecaton::planner {

/// A shape whose capsule would have more than this many times its volume keeps its own form.
inline constexpr double kMostCapsuleVolume = 2.0;

struct LinkCapsule {
  PlacedCapsule placed;  ///< encloses the shape; in the shape's frame S
  double excess_volume;  ///< volume(capsule) / volume(shape) − 1
};

/// Nothing for balls and capsules, which need none, and for shapes that no capsule fits (kMostCapsuleVolume).
[[nodiscard]] std::optional<LinkCapsule> link_capsule(const world::Shape& shape);

/// Volume [m³].
[[nodiscard]] double volume(const world::Shape& shape);

}  // namespace hecaton::planner
