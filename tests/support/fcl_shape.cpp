#include "tests/support/fcl_shape.hpp"

#include <stdexcept>
#include <string>
#include <vector>

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>

namespace hecaton::test {
namespace {

struct ToFcl {
  using Result = std::shared_ptr<fcl::CollisionGeometryd>;

  Result operator()(const world::Box& box) const {
    return std::make_shared<fcl::Boxd>(Eigen::Vector3d(2.0 * box.half_extents));
  }
  Result operator()(const world::Sphere& sphere) const { return std::make_shared<fcl::Sphered>(sphere.radius); }
  Result operator()(const world::Capsule& capsule) const {
    return std::make_shared<fcl::Capsuled>(capsule.radius, 2.0 * capsule.half_length);
  }
  Result operator()(const world::Cylinder& cylinder) const {
    return std::make_shared<fcl::Cylinderd>(cylinder.radius, 2.0 * cylinder.half_length);
  }
  Result operator()(const world::Convex& convex) const {
    auto faces = std::make_shared<std::vector<int>>();  // each as its number of vertices, then these
    for (const auto& face : convex.hull->faces) {
      faces->push_back(static_cast<int>(face.size()));
      faces->insert(faces->end(), face.begin(), face.end());
    }
    const auto vertices = std::make_shared<std::vector<Eigen::Vector3d>>(convex.hull->vertices);
    return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(convex.hull->faces.size()), faces);
  }
  Result operator()(const world::Points& points) const {
    throw std::logic_error("no convex shape: " + std::to_string(points.cloud->size()) + " points");
  }
};

}  // namespace

std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const world::Shape& shape) {
  return std::visit(ToFcl{}, shape);
}

}  // namespace hecaton::test
