#include "services/config/shape_types.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace hecaton::config {
namespace {

world::Shape make_sphere(std::span<const double> sizes) {
  return world::Sphere{sizes[0]};
}

world::Shape make_capsule(std::span<const double> sizes) {
  return world::Capsule{sizes[0], 0.5 * sizes[1]};
}

world::Shape make_cylinder(std::span<const double> sizes) {
  return world::Cylinder{sizes[0], 0.5 * sizes[1]};
}

}  // namespace

const std::vector<ShapeType>& shape_types() {
  static const std::vector<ShapeType> types = {
      {"sphere", "radius [m]", {{"radius"}}, make_sphere},
      {"capsule",
       "radius and length between the caps' centres [m], axis along z",
       {{"radius"}, {"length", 0.0}},
       make_capsule},
      {"cylinder", "radius and height [m], axis along z", {{"radius"}, {"height"}}, make_cylinder},
  };
  return types;
}

world::Shape make_shape(const ShapeType& type, std::span<const double> sizes) {
  for (std::size_t i = 0; i < type.sizes.size(); ++i) {
    const Bounds bounds = type.sizes[i].bounds();
    if (bounds.allow(sizes[i])) continue;
    throw std::invalid_argument(std::string(type.sizes[i].key) + " = " + number_text(sizes[i]) + " m must be " +
                                (std::isfinite(sizes[i]) ? "" : "a finite number, ") + bounds.text());
  }
  return type.make(sizes);
}

}  // namespace hecaton::config
