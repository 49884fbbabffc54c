#pragma once
/// Conversion of shapes to FCL.

#include <memory>

#include <fcl/geometry/collision_geometry.h>

#include "world/model/shape.hpp"

namespace hecaton::test {

[[nodiscard]] std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const world::Shape& shape);

}  // namespace hecaton::test
