#include "services/config/check_start.hpp"

#include <cmath>
#include <numbers>
#include <variant>

#include "services/config/config_error.hpp"
#include "services/config/placed_bodies.hpp"

namespace hecaton::config {
namespace {

using Bodies = std::vector<PlacedBody>;

std::string arm_key(const std::string& file, int arm) {
  return file + ": arms[" + std::to_string(arm) + "]";
}

Bodies fixed_part(const Bodies& bodies) {
  Bodies fixed;
  for (const PlacedBody& body : bodies) {
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

void check_bases(const std::vector<Bodies>& arms, const std::string& file) {
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    for (int j = i + 1; j < static_cast<int>(arms.size()); ++j) {
      const NearestPair pair = nearest_pair(fixed_part(arms[i]), fixed_part(arms[j]), 0.0, false);
      if (!pair.found) continue;
      throw ConfigError(arm_key(file, j) + ".base must be clear of arms[" + std::to_string(i) + "], but " +
                        overlap_text(pair));
    }
  }
}

void check_self(const planner::Cell& cell, const planner::CellGeometry& geometry, int arm, const std::string& file) {
  for (const auto& [name, q] : cell.arms[arm].arm.named) {
    const NearestPair pair =
        nearest_self_pair(place_arm(cell.scene.obstacles, geometry, arm, q), geometry.self_pairs(), 0.0);
    if (!pair.found) continue;
    throw ConfigError(arm_key(file, arm) + ".poses." + name + " must be free of self-collision, but " +
                      overlap_text(pair));
  }
}

void check_others(const planner::Cell& cell, const std::vector<Bodies>& arms, const std::vector<Bodies>& obstacles,
                  int arm, const std::string& file) {
  const std::string key = arm_key(file, arm) + ".start = " + pose_name(cell.arms[arm]);
  for (int other = 0; other < arm; ++other) {
    const NearestPair pair = nearest_pair(arms[arm], arms[other], 0.0, false);
    if (pair.found) throw ConfigError(key + " must be clear of the other arms, but " + overlap_text(pair));
  }
  for (const Bodies& obstacle : obstacles) {
    const NearestPair pair = overlap_of_moving(arms[arm], obstacle);
    if (pair.found) throw ConfigError(key + " must be clear of the obstacles, but " + overlap_text(pair));
  }
}

/// All arms stand there at once; obstacles that move may be elsewhere by then.
void check_stop(const planner::Cell& cell, const planner::CellGeometry& geometry, const std::vector<Bodies>& obstacles,
                int stop, const std::string& file) {
  const std::string& pose = cell.tasks.pose_sequence[stop];
  const std::string key = file + ": tasks.pose_sequence[" + std::to_string(stop) + "] = " + pose;
  std::vector<Bodies> arms;
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    arms.push_back(place_arm(cell.scene.obstacles, geometry, arm, cell.arms[arm].arm.named.at(pose)));
    for (int other = 0; other < arm; ++other) {
      const NearestPair pair = nearest_pair(arms[arm], arms[other], 0.0, false);
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
  check_bases(arms, file);
  for (int arm = 0; arm < static_cast<int>(arms.size()); ++arm) check_others(cell, arms, obstacles, arm, file);
  if (arms.empty() || cell.tasks.pose_sequence.empty()) return;
  planner::CellGeometry geometry(models, 0);
  geometry.set_obstacles(cell.scene.obstacles);
  for (int stop = 0; stop < static_cast<int>(cell.tasks.pose_sequence.size()); ++stop) {
    check_stop(cell, geometry, obstacles, stop, file);
  }
}

}  // namespace hecaton::config
