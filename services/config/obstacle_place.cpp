#include "services/config/obstacle_place.hpp"

#include "services/config/placed_bodies.hpp"

namespace hecaton::config {

std::string overlap_with_arms(std::span<const planner::PlannedArm> arms, MeasuredJoints q,
                              std::span<const world::Obstacle> others, const world::Obstacle& obstacle,
                              const world::Pose& X_WO) {
  if (arms.empty()) return {};
  std::vector<planner::Arm> models;
  for (const planner::PlannedArm& planned : arms) models.push_back(planned.arm);
  std::vector<world::Obstacle> obstacles;
  for (const world::Obstacle& other : others) {
    if (other.attachment && other.name != obstacle.name) obstacles.push_back(other);
  }
  const int last = static_cast<int>(obstacles.size());
  obstacles.push_back(obstacle);
  planner::CellGeometry geometry(std::move(models), 0);
  geometry.set_obstacles(obstacles);
  const std::vector<PlacedBody> bodies = place_obstacle(geometry, obstacle.name, X_WO, last);
  // What stands may stand at a fixed base.
  const bool stands = std::holds_alternative<world::StaticMotion>(obstacle.motion);
  for (int arm = 0; arm < static_cast<int>(arms.size()); ++arm) {
    if (!q[static_cast<std::size_t>(arm)]) continue;
    const NearestPair pair =
        nearest_pair(place_arm(obstacles, geometry, arm, *q[static_cast<std::size_t>(arm)]), bodies, 0.0, stands);
    if (pair.found) return overlap_text(pair);
  }
  return {};
}

}  // namespace hecaton::config
