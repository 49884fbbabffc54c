#pragma once
/// Capsules that enclose a point set or a shape.

#include <span>

#include "world/model/shape.hpp"

namespace hecaton::planner {

/// A capsule and where it is: its own frame S (axis z) in the frame F of the points.
struct PlacedCapsule {
  world::Capsule capsule;
  world::Pose X_FS = world::Pose::Identity();
};

/// A capsule of small volume, found by deterministic local search over its axis' direction, that encloses all points
/// (at least one) [m].
[[nodiscard]] PlacedCapsule enclosing_capsule(std::span<const Eigen::Vector3d> points);

/// The same for a shape: a ball or capsule itself; around a box or cylinder the smallest one along its longest axis;
/// around a hull a good one, found in microseconds.
[[nodiscard]] PlacedCapsule bounding_capsule(const world::Shape& shape);

/// Volume [m³].
[[nodiscard]] double volume(const world::Capsule& capsule);

}  // namespace hecaton::planner
