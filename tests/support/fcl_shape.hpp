#pragma once
/// Our shapes as FCL's, to measure the same pairs with both.

#include <memory>

#include <fcl/geometry/collision_geometry.h>

#include "world/model/shape.hpp"

namespace hecaton::test {

[[nodiscard]] std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const world::Shape& shape);

}  // namespace hecaton::test
