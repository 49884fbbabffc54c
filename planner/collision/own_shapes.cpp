#include "planner/collision/own_shapes.hpp"

#include "planner/collision/exact_distance.hpp"
#include "planner/model/kinematics.hpp"

namespace hecaton::planner {

double distance_of_own_shapes(const CellGeometry& geometry, const CellPoses& poses, const Clearance& clearance) {
  const Body& own = geometry.own_bodies()[clearance.own_body];
  const auto distance_to = [&](const Body& other, const Pose& X_WC) {
    return shape_distance(own.shape, poses.own->X_WL[own.link] * own.X_CS, other.shape, X_WC * other.X_CS).distance;
  };
  switch (clearance.counterpart) {
    case Counterpart::kSelf: {
      const Body& other = geometry.own_bodies()[clearance.other_body];
      return distance_to(other, poses.own->X_WL[other.link]);
    }
    case Counterpart::kArm: {
      const Body& other = geometry.arm_bodies(clearance.other)[clearance.other_body];
      return distance_to(other, poses.arms[clearance.other].X_WL[other.link]);
    }
    case Counterpart::kObstacle:
      break;
  }
  const Body& other = geometry.obstacle_bodies(clearance.other)[clearance.other_body];
  return distance_to(other, poses.obstacles[clearance.other].X_WO);
}

}  // namespace hecaton::planner
