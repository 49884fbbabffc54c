#pragma once
/// A shape of an obstacle: box, sphere, capsule, cylinder, or the convex hull of a mesh file.

#include "services/config/yaml_view.hpp"
#include "world/model/shape.hpp"

namespace hecaton::config {

[[nodiscard]] world::PlacedShape read_shape(const YamlView& view);

}  // namespace hecaton::config
