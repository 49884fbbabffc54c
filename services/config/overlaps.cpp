#include "services/config/overlaps.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "planner/collision/exact_distance.hpp"
#include "services/config/text.hpp"
#include "services/config/yaml_tree.hpp"

namespace hecaton::config {
namespace {

using Bodies = std::vector<PosedBody>;

void consider(const PosedBody& a, const PosedBody& b, NearestPair& nearest, double& within) {
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

std::vector<PosedBody> place_arm(std::span<const world::Obstacle> obstacles, const planner::CellGeometry& geometry,
                                 int arm, const planner::JointVector& q) {
  const planner::Arm& placed = geometry.arms()[arm];
  planner::Kinematics kinematics;
  planner::forward_kinematics(*placed.model, placed.X_WB, q, kinematics);
  std::vector<PosedBody> bodies;
  for (const planner::Body& body : geometry.arm_bodies(arm)) {
    const std::string& part = body.obstacle >= 0 ? obstacles[body.obstacle].name : placed.model->links[body.link].name;
    bodies.push_back({body, kinematics.X_WL[body.link] * body.X_CS, placed.name + "/" + part});
  }
  return bodies;
}

std::vector<PosedBody> place_obstacle(const planner::CellGeometry& geometry, const std::string& name,
                                      const world::Pose& X_WO, int index) {
  std::vector<PosedBody> bodies;
  for (const planner::Body& body : geometry.obstacle_bodies(index)) {
    bodies.push_back({body, X_WO * body.X_CS, name});
  }
  return bodies;
}

std::vector<PosedBody> place_obstacle(const planner::CellGeometry& geometry, const world::Obstacle& obstacle,
                                      int index) {
  return place_obstacle(geometry, obstacle.name, initial_pose(obstacle), index);
}

NearestPair nearest_pair(const std::vector<PosedBody>& a, const std::vector<PosedBody>& b, double within,
                         bool moving_a_only) {
  NearestPair nearest;
  for (const PosedBody& body_a : a) {
    if (moving_a_only && !body_a.body.moves) continue;
    for (const PosedBody& body_b : b) consider(body_a, body_b, nearest, within);
  }
  return nearest;
}

NearestPair nearest_pair_of_arms(const planner::Arm& a, const std::vector<PosedBody>& bodies_a, const planner::Arm& b,
                                 const std::vector<PosedBody>& bodies_b, double within) {
  const bool only_moving = planner::same_robot(a, b);
  NearestPair nearest;
  for (const PosedBody& body_a : bodies_a) {
    if (only_moving && !body_a.body.moves) continue;
    for (const PosedBody& body_b : bodies_b) {
      if (!only_moving || body_b.body.moves) consider(body_a, body_b, nearest, within);
    }
  }
  return nearest;
}

NearestPair overlap_of_moving(const std::vector<PosedBody>& arm, const std::vector<PosedBody>& obstacle) {
  return nearest_pair(arm, obstacle, 0.0, true);
}

NearestPair nearest_self_pair(const std::vector<PosedBody>& bodies, const planner::CellGeometry& geometry,
                              double within, double share) {
  NearestPair nearest;
  for (const auto& [first, second] : geometry.self_pairs()) {
    double least = std::min(nearest.found ? nearest.distance : within, share * geometry.widest(first, second));
    consider(bodies[first], bodies[second], nearest, least);
  }
  return nearest;
}

std::string overlap_text(const NearestPair& pair) {
  return pair.a + " and " + pair.b + " overlap by " + number_text(-pair.distance * 1e3) + " mm";
}

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
  const std::vector<PosedBody> bodies = place_obstacle(geometry, obstacle.name, X_WO, last);
  // A static obstacle may overlap a fixed base.
  const bool stands = std::holds_alternative<world::StaticMotion>(obstacle.motion);
  for (int arm = 0; arm < static_cast<int>(arms.size()); ++arm) {
    if (!q[static_cast<std::size_t>(arm)]) continue;
    const NearestPair pair =
        nearest_pair(place_arm(obstacles, geometry, arm, *q[static_cast<std::size_t>(arm)]), bodies, 0.0, stands);
    if (pair.found) return overlap_text(pair);
  }
  return {};
}

namespace {

std::string arm_place(const std::string& file, int arm) {
  return file + ": arms[" + std::to_string(arm) + "]";
}

Bodies fixed_part(const Bodies& bodies) {
  Bodies fixed;
  for (const PosedBody& body : bodies) {
    if (!body.body.moves) fixed.push_back(body);
  }
  return fixed;
}

std::string pose_name(const planner::PlannedArm& planned) {
  for (const auto& [name, q] : planned.arm.named) {
    if (q == planned.start) return name;
  }
  return "start";
}

void check_bases(const planner::Cell& cell, const std::vector<Bodies>& arms, const std::string& file) {
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    for (int j = i + 1; j < static_cast<int>(arms.size()); ++j) {
      if (planner::same_robot(cell.arms[i].arm, cell.arms[j].arm)) continue;
      const NearestPair pair = nearest_pair(fixed_part(arms[i]), fixed_part(arms[j]), 0.0, false);
      if (!pair.found) continue;
      throw ConfigError(arm_place(file, j) + ".base must be clear of arms[" + std::to_string(i) + "], but " +
                        overlap_text(pair));
    }
  }
}

/// What to do about an overlap with an obstacle that the arm carries; empty: it carries neither body.
std::string remedy(const planner::Cell& cell, const NearestPair& pair) {
  for (const world::Obstacle& obstacle : cell.scene.obstacles) {
    if (!obstacle.attachment) continue;
    const std::string carried = obstacle.attachment->arm + "/" + obstacle.name;
    if (pair.a != carried && pair.b != carried) continue;
    return "; change attached_to.pose of obstacle " + obstacle.name + ", which is in the tool frame, or this pose";
  }
  return {};
}

void check_self(const planner::Cell& cell, const planner::CellGeometry& geometry, int arm, const std::string& file) {
  for (const auto& [name, q] : cell.arms[arm].arm.named) {
    const NearestPair pair = nearest_self_pair(place_arm(cell.scene.obstacles, geometry, arm, q), geometry, 0.0);
    if (!pair.found) continue;
    throw ConfigError(arm_place(file, arm) + ".poses." + name + " must be free of self-collision, but " +
                      overlap_text(pair) + remedy(cell, pair));
  }
}

void check_others(const planner::Cell& cell, const std::vector<Bodies>& arms, const std::vector<Bodies>& obstacles,
                  int arm, const std::string& file) {
  const std::string key = arm_place(file, arm) + ".start = " + pose_name(cell.arms[arm]);
  for (int other = 0; other < arm; ++other) {
    const NearestPair pair =
        nearest_pair_of_arms(cell.arms[arm].arm, arms[arm], cell.arms[other].arm, arms[other], 0.0);
    if (pair.found) throw ConfigError(key + " must be clear of the other arms, but " + overlap_text(pair));
  }
  for (const Bodies& obstacle : obstacles) {
    const NearestPair pair = overlap_of_moving(arms[arm], obstacle);
    if (pair.found) throw ConfigError(key + " must be clear of the obstacles, but " + overlap_text(pair));
  }
}

/// True when a start or the tasks need the pose.
bool is_used(const planner::Cell& cell, const planner::PlannedArm& planned, const std::string& name) {
  const auto contains = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto areas = cell.tasks.problem.areas.find(planned.arm.name);
  return name == "home" || planned.start == planned.arm.named.at(name) || name == cell.tasks.posture ||
         contains(cell.tasks.pose_sequence) || (areas != cell.tasks.problem.areas.end() && contains(areas->second));
}

/// All arms are at the stop at the same time. Obstacles that move may be elsewhere by then.
void check_stop(const planner::Cell& cell, const planner::CellGeometry& geometry, const std::vector<Bodies>& obstacles,
                int stop, const std::string& file) {
  const std::string& pose = cell.tasks.pose_sequence[stop];
  const std::string key = file + ": tasks.pose_sequence[" + std::to_string(stop) + "] = " + pose;
  std::vector<Bodies> arms;
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    arms.push_back(place_arm(cell.scene.obstacles, geometry, arm, cell.arms[arm].arm.named.at(pose)));
    for (int other = 0; other < arm; ++other) {
      const NearestPair pair =
          nearest_pair_of_arms(cell.arms[arm].arm, arms[arm], cell.arms[other].arm, arms[other], 0.0);
      if (pair.found) throw ConfigError(key + " must keep all arms clear of each other, but " + overlap_text(pair));
    }
    for (int i = 0; i < static_cast<int>(obstacles.size()); ++i) {
      if (!std::holds_alternative<world::StaticMotion>(cell.scene.obstacles[i].motion)) continue;
      const NearestPair pair = overlap_of_moving(arms[arm], obstacles[i]);
      if (pair.found) throw ConfigError(key + " must be clear of obstacles that stand, but " + overlap_text(pair));
    }
  }
}

}  // namespace

world::Pose initial_pose(const world::Obstacle& obstacle) {
  world::Pose X_WO = obstacle.X_WO;
  if (const auto* sine = std::get_if<world::SineMotion>(&obstacle.motion)) {
    X_WO.translation() += sine->direction_W * (sine->amplitude * std::sin(sine->phase));
  }
  if (const auto* waypoints = std::get_if<world::WaypointMotion>(&obstacle.motion)) X_WO = waypoints->poses_W.front();
  return X_WO;
}

void leave_out_poses(planner::Cell& cell, std::vector<std::string>& notes) {
  const std::vector<planner::Arm> models = arms_of(cell);
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    planner::PlannedArm& planned = cell.arms[arm];
    if (planned.arm.model->named.empty()) continue;
    planner::CellGeometry geometry(models, arm);
    geometry.set_obstacles(cell.scene.obstacles);
    for (const auto& [name, q] : planned.arm.model->named) {
      const auto pose = planned.arm.named.find(name);
      if (pose == planned.arm.named.end() || pose->second != q || is_used(cell, planned, name)) continue;
      const NearestPair pair = nearest_self_pair(place_arm(cell.scene.obstacles, geometry, arm, q), geometry, 0.0);
      if (!pair.found) continue;
      planned.arm.named.erase(pose);
      notes.push_back("arms[" + std::to_string(arm) + "]: pose " + name + " of the SRDF is left out, because " +
                      overlap_text(pair));
    }
  }
}

void check_start(const planner::Cell& cell, const std::string& file) {
  const std::vector<planner::Arm> models = arms_of(cell);
  std::vector<Bodies> arms;
  std::vector<Bodies> obstacles;
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    planner::CellGeometry geometry(models, arm);
    geometry.set_obstacles(cell.scene.obstacles);
    check_self(cell, geometry, arm, file);
    arms.push_back(place_arm(cell.scene.obstacles, geometry, arm, cell.arms[arm].start));
    if (arm > 0) continue;
    for (int i = 0; i < static_cast<int>(cell.scene.obstacles.size()); ++i) {
      obstacles.push_back(place_obstacle(geometry, cell.scene.obstacles[i], i));
    }
  }
  check_bases(cell, arms, file);
  for (int arm = 0; arm < static_cast<int>(arms.size()); ++arm) check_others(cell, arms, obstacles, arm, file);
  if (arms.empty() || cell.tasks.pose_sequence.empty()) return;
  planner::CellGeometry geometry(models, 0);
  geometry.set_obstacles(cell.scene.obstacles);
  for (int stop = 0; stop < static_cast<int>(cell.tasks.pose_sequence.size()); ++stop) {
    check_stop(cell, geometry, obstacles, stop, file);
  }
}

}  // namespace hecaton::config
