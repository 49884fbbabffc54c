#include "services/config/placed_bodies.hpp"

#include "planner/collision/exact_distance.hpp"
#include "services/config/check_start.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

void consider(const PlacedBody& a, const PlacedBody& b, NearestPair& nearest, double& within) {
  const auto bound_a = world::bounding_sphere(a.body.shape);
  const auto bound_b = world::bounding_sphere(b.body.shape);
  const double apart = (a.X_WS * bound_a.centre - b.X_WS * bound_b.centre).norm() - bound_a.radius - bound_b.radius;
  if (apart >= within) return;
  const double distance = planner::shape_distance(a.body.shape, a.X_WS, b.body.shape, b.X_WS).distance;
  if (distance >= within) return;
  nearest = {true, a.name, b.name, distance};
  within = distance;
}

}  // namespace

std::vector<PlacedBody> place_arm(std::span<const world::Obstacle> obstacles, const planner::CellGeometry& geometry,
                                  int arm, const planner::JointVector& q) {
  const planner::Arm& placed = geometry.arms()[arm];
  planner::Kinematics kinematics;
  planner::forward_kinematics(*placed.model, placed.X_WB, q, kinematics);
  std::vector<PlacedBody> bodies;
  for (const planner::Body& body : geometry.arm_bodies(arm)) {
    const std::string& part = body.obstacle >= 0 ? obstacles[body.obstacle].name : placed.model->links[body.link].name;
    bodies.push_back({body, kinematics.X_WL[body.link] * body.X_CS, placed.name + "/" + part});
  }
  return bodies;
}

std::vector<PlacedBody> place_obstacle(const planner::CellGeometry& geometry, const std::string& name,
                                       const world::Pose& X_WO, int index) {
  std::vector<PlacedBody> bodies;
  for (const planner::Body& body : geometry.obstacle_bodies(index)) {
    bodies.push_back({body, X_WO * body.X_CS, name});
  }
  return bodies;
}

std::vector<PlacedBody> place_obstacle(const planner::CellGeometry& geometry, const world::Obstacle& obstacle,
                                       int index) {
  return place_obstacle(geometry, obstacle.name, initial_pose(obstacle), index);
}

NearestPair nearest_pair(const std::vector<PlacedBody>& a, const std::vector<PlacedBody>& b, double within,
                         bool moving_a_only) {
  NearestPair nearest;
  for (const PlacedBody& body_a : a) {
    if (moving_a_only && !body_a.body.moves) continue;
    for (const PlacedBody& body_b : b) consider(body_a, body_b, nearest, within);
  }
  return nearest;
}

NearestPair overlap_of_moving(const std::vector<PlacedBody>& arm, const std::vector<PlacedBody>& obstacle) {
  return nearest_pair(arm, obstacle, 0.0, true);
}

NearestPair nearest_self_pair(const std::vector<PlacedBody>& bodies, const std::vector<std::pair<int, int>>& pairs,
                              double within) {
  NearestPair nearest;
  for (const auto& [first, second] : pairs) consider(bodies[first], bodies[second], nearest, within);
  return nearest;
}

std::string overlap_text(const NearestPair& pair) {
  return pair.a + " and " + pair.b + " overlap by " + number_text(-pair.distance * 1e3) + " mm";
}

}  // namespace hecaton::config
