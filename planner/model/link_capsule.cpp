#include "planner/model/link_capsule.hpp"

#include <numbers>

#include "planner/model/convex_hull.hpp"

namespace hecaton::planner {

double volume(const world::Shape& shape) {
  struct Visitor {
    double operator()(const world::Box& box) const { return 8.0 * box.half_extents.prod(); }
    double operator()(const world::Sphere& sphere) const { return volume(world::Capsule{sphere.radius, 0.0}); }
    double operator()(const world::Capsule& capsule) const { return volume(capsule); }
    double operator()(const world::Cylinder& cylinder) const {
      return 2.0 * std::numbers::pi * cylinder.radius * cylinder.radius * cylinder.half_length;
    }
    double operator()(const world::Convex& convex) const { return volume(*convex.hull); }
  };
  return std::visit(Visitor{}, shape);
}

std::optional<LinkCapsule> link_capsule(const world::Shape& shape) {
  if (std::holds_alternative<world::Sphere>(shape) || std::holds_alternative<world::Capsule>(shape)) return {};
  const auto* convex = std::get_if<world::Convex>(&shape);
  const PlacedCapsule placed = convex != nullptr ? enclosing_capsule(convex->hull->vertices) : bounding_capsule(shape);
  const double times = volume(placed.capsule) / volume(shape);
  if (times > kMostCapsuleVolume) return {};
  return LinkCapsule{placed, times - 1.0};
}

}  // namespace hecaton::planner
