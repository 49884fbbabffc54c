#include <algorithm>
#include <variant>

#include "services/config/findings.hpp"
#include "services/config/placed_bodies.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

using Bodies = std::vector<PlacedBody>;

std::string apart_text(const NearestPair& pair) {
  if (pair.distance < 0.0) return overlap_text(pair);
  return pair.a + " and " + pair.b + " are " + number_text(pair.distance * 1e3) + " mm apart";
}

void add(const std::string& key, const NearestPair& pair, double needed, const std::string& consequence,
         Findings& findings) {
  findings.push_back({Severity::kWarning, key + ": " + apart_text(pair) + ", nearer than the security distance of " +
                                              number_text(needed * 1e3) + " mm: " + consequence});
}

Bodies standing_obstacles(const planner::Cell& cell, const planner::CellGeometry& geometry) {
  Bodies bodies;
  for (int i = 0; i < static_cast<int>(cell.scene.obstacles.size()); ++i) {
    if (!std::holds_alternative<world::StaticMotion>(cell.scene.obstacles[i].motion)) continue;
    for (PlacedBody& body : place_obstacle(geometry, cell.scene.obstacles[i], i)) bodies.push_back(std::move(body));
  }
  return bodies;
}

void check_poses(const planner::Cell& cell, const planner::CellGeometry& geometry, int arm, const Bodies& standing,
                 Findings& findings) {
  const planner::PlannedArm& planned = cell.arms[arm];
  const planner::DamperParameters& damper = planned.parameters.damper;
  const std::string consequence = "the arm never quite gets there";
  for (const auto& [name, q] : planned.arm.named) {
    const std::string key = arm_key(arm) + ".poses." + name;
    const Bodies bodies = place_arm(cell.scene.obstacles, geometry, arm, q);
    const NearestPair self = nearest_self_pair(bodies, geometry.self_pairs(), damper.self_security_distance);
    if (self.found) add(key, self, damper.self_security_distance, consequence, findings);
    const NearestPair obstacle = nearest_pair(bodies, standing, damper.security_distance, true);
    if (obstacle.found) add(key, obstacle, damper.security_distance, consequence, findings);
  }
}

/// All arms in these poses of theirs at once.
void check_apart(const planner::Cell& cell, const planner::CellGeometry& geometry,
                 const std::vector<planner::JointVector>& poses, const std::string& key, const std::string& consequence,
                 Findings& findings) {
  std::vector<Bodies> arms;
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    arms.push_back(place_arm(cell.scene.obstacles, geometry, arm, poses[arm]));
    for (int other = 0; other < arm; ++other) {
      const double needed = std::max(cell.arms[arm].parameters.damper.security_distance,
                                     cell.arms[other].parameters.damper.security_distance);
      const NearestPair pair = nearest_pair(arms[arm], arms[other], needed, false);
      if (pair.found) add(key.empty() ? arm_key(arm) + ".start" : key, pair, needed, consequence, findings);
    }
  }
}

}  // namespace

void check_clearances(const planner::Cell& cell, Findings& findings) {
  if (cell.arms.empty()) return;
  const std::vector<planner::Arm> models = arms_of(cell);
  std::vector<planner::JointVector> starts;
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    planner::CellGeometry geometry(models, arm);
    geometry.set_obstacles(cell.scene.obstacles);
    check_poses(cell, geometry, arm, standing_obstacles(cell, geometry), findings);
    starts.push_back(cell.arms[arm].start);
  }
  planner::CellGeometry geometry(models, 0);
  geometry.set_obstacles(cell.scene.obstacles);
  check_apart(cell, geometry, starts, "", "both arms begin with a retreat", findings);
  for (std::size_t stop = 0; stop < cell.tasks.pose_sequence.size(); ++stop) {
    std::vector<planner::JointVector> poses;
    for (const auto& planned : cell.arms) poses.push_back(planned.arm.named.at(cell.tasks.pose_sequence[stop]));
    const std::string key = "tasks.pose_sequence[" + std::to_string(stop) + "] = " + cell.tasks.pose_sequence[stop];
    check_apart(cell, geometry, poses, key, "the arms never quite get there at once", findings);
  }
}

}  // namespace hecaton::config
