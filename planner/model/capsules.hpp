#pragma once
/// Capsules that enclose shapes or point sets, and capsules that a URDF writes as a cylinder with two balls.

#include <optional>
#include <span>
#include <vector>

#include "world/model/shape.hpp"

namespace hecaton::planner {

/// A capsule and the pose of its frame S (axis z) in the frame F of the points.
struct PlacedCapsule {
  world::Capsule capsule;
  world::Pose X_FS = world::Pose::Identity();
};

/// A capsule of small volume that encloses all points (at least one) [m]. The result of a local search over the axis
/// direction, which starts from the coordinate axes and the principal axes [Welzl91 for the radius]; deterministic.
[[nodiscard]] PlacedCapsule enclosing_capsule(std::span<const Eigen::Vector3d> points);

/// A capsule that encloses the shape, in the shape's frame: a sphere or capsule itself; around a box or cylinder the
/// smallest one along the longest axis; around a hull the one along the longest principal axis (microseconds).
[[nodiscard]] PlacedCapsule bounding_capsule(const world::Shape& shape);

/// Volume [m³].
[[nodiscard]] double volume(const world::Capsule& capsule);

/// A shape whose capsule would have more than this many times its volume keeps its own form.
inline constexpr double kMostCapsuleVolume = 2.0;

/// The capsule that replaces a link's collision shape where speed matters more than the last millimetre.
struct LinkCapsule {
  PlacedCapsule placed;  ///< encloses the shape; in the shape's frame S
  double excess_volume;  ///< volume(capsule) / volume(shape) − 1
};

/// Empty for spheres and capsules, which need none, and for shapes that no capsule fits (kMostCapsuleVolume).
[[nodiscard]] std::optional<LinkCapsule> link_capsule(const world::Shape& shape);

/// Volume [m³].
[[nodiscard]] double volume(const world::Shape& shape);

/// URDF has no capsules: files write them as a cylinder with a sphere at either end. Replaces each cylinder that has
/// two spheres of its radius at the centres of its ends (within 10 µm) by one capsule. Other shapes and the order stay.
[[nodiscard]] std::vector<world::PlacedShape> merge_capsules(const std::vector<world::PlacedShape>& shapes);

}  // namespace hecaton::planner
