#include "planner/collision/swept_core.hpp"

namespace hecaton::planner {

SweptCore make_swept_core(const world::Shape& shape) {
  using Eigen::Vector3d;
  struct Visitor {
    SweptCore operator()(const world::Box& box) const {
      return {Core::kBox, 0.0, box.half_extents, Vector3d::Zero(), {}};
    }
    SweptCore operator()(const world::Sphere& sphere) const {
      return {Core::kPoint, sphere.radius, Vector3d::Zero(), Vector3d::Zero(), {}};
    }
    SweptCore operator()(const world::Capsule& capsule) const {
      return {Core::kSegment, capsule.radius, {0.0, 0.0, capsule.half_length}, Vector3d::Zero(), {}};
    }
    SweptCore operator()(const world::Cylinder& cylinder) const {
      return {Core::kCylinder, 0.0, {cylinder.radius, cylinder.radius, cylinder.half_length}, Vector3d::Zero(), {}};
    }
    SweptCore operator()(const world::Convex& convex) const {
      return {Core::kHull, 0.0, Vector3d::Zero(), world::bounding_sphere(convex).centre,
              HullVertices(convex.hull->vertices)};
    }
  };
  return std::visit(Visitor{}, shape);
}

}  // namespace hecaton::planner
