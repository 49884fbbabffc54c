#include <algorithm>
#include <limits>
#include <numbers>

#include "planner/local/random.hpp"
#include "services/config/findings.hpp"
#include "services/config/placed_bodies.hpp"
#include "services/config/text.hpp"
#include "services/config/top_speed.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::config {
namespace {

constexpr double kWatched = 60.0;  // of a script [s]
constexpr int kSamples = 600;
constexpr int kConfigurations = 200;   // of each arm, to find out whether it reaches something
constexpr double kSuddenChange = 0.1;  // of a velocity that dampers and margins do not absorb [m/s]

using Bodies = std::vector<PlacedBody>;

Bodies fixed_parts(const planner::Cell& cell, const planner::CellGeometry& geometry) {
  Bodies fixed;
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    for (PlacedBody& body : place_arm(cell.scene.obstacles, geometry, arm, cell.arms[arm].start)) {
      if (!body.body.moves) fixed.push_back(std::move(body));
    }
  }
  return fixed;
}

// docs/design/0010-passing-obstacles.md: what an arm takes for the most that an obstacle's velocity changes.
void check_acceleration(const planner::Cell& cell, const world::Obstacle& obstacle, const std::string& key,
                        Findings& findings) {
  const double needed = world::greatest_acceleration(obstacle);
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    const double allowed = cell.arms[arm].parameters.acceleration_of_obstacles;
    if (needed <= allowed) continue;
    findings.push_back({Severity::kWarning, key + " accelerates by up to " + number_text(needed) + " m/s², more than " +
                                                arm_key(arm) + ".acceleration_of_obstacles = " + number_text(allowed) +
                                                ": the arm takes it for farther away than it may be"});
    return;
  }
}

std::string point_text(const Eigen::Vector3d& p) {
  return "(" + number_text(p.x()) + ", " + number_text(p.y()) + ", " + number_text(p.z()) + ")";
}

bool reaches(const planner::Cell& cell, const planner::CellGeometry& geometry, int arm, const Bodies& obstacle) {
  const planner::PlannedArm& planned = cell.arms[arm];
  planner::Random random(1);
  planner::JointVector q(planned.arm.model->joints());
  for (int sample = 0; sample < kConfigurations; ++sample) {
    for (int joint = 0; joint < q.size(); ++joint) {
      q[joint] = random.uniform(std::max(planned.arm.limits.lower[joint], -std::numbers::pi),
                                std::min(planned.arm.limits.upper[joint], std::numbers::pi));
    }
    const Bodies bodies = place_arm(cell.scene.obstacles, geometry, arm, q);
    if (nearest_pair(bodies, obstacle, planned.parameters.damper.influence_distance, true).found) return true;
  }
  return false;
}

/// What changes its place or velocity at once, where an arm may be, nobody can make way for.
void check_breaks(const planner::Cell& cell, const planner::CellGeometry& geometry, int index, const std::string& key,
                  Findings& findings) {
  const world::Obstacle& obstacle = cell.scene.obstacles[index];
  for (const world::ScriptBreak& one : world::script_breaks(obstacle)) {
    if (one.jump == 0.0 && one.velocity_change <= kSuddenChange) continue;
    const Bodies there = place_obstacle(geometry, obstacle.name, one.X_WO, index);
    for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
      if (!reaches(cell, geometry, arm, there)) continue;
      const std::string what = one.jump > 0.0
                                   ? " starts again"
                                   : " changes its velocity by " + number_text(one.velocity_change) + " m/s at once";
      findings.push_back({Severity::kWarning, key + what + " at " + point_text(one.X_WO.translation()) +
                                                  ", within reach of " + arm_key(arm) +
                                                  ": an arm that is there cannot make way in time"});
      return;
    }
  }
}

void check_one(const planner::Cell& cell, const planner::CellGeometry& geometry, int index, const Bodies& fixed,
               double slowest_arm, Findings& findings) {
  const world::Obstacle& obstacle = cell.scene.obstacles[index];
  const std::string key = "obstacles[" + std::to_string(index) + "].motion";
  Bodies bodies = place_obstacle(geometry, obstacle, index);
  double speed = 0.0;
  NearestPair deepest;
  for (int sample = 0; sample < kSamples; ++sample) {
    const world::MotionState state = world::motion_at(obstacle, kWatched * sample / kSamples);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      bodies[i].X_WS = state.X_WO * geometry.obstacle_bodies(index)[i].X_CS;
    }
    speed = std::max(speed, state.velocity.linear.norm());
    const NearestPair pair = nearest_pair(fixed, bodies, deepest.found ? deepest.distance : 0.0, false);
    if (pair.found) deepest = pair;
  }
  if (deepest.found) {
    findings.push_back(
        {Severity::kWarning, key + " leads through a part that cannot give way: " + overlap_text(deepest)});
  }
  check_acceleration(cell, obstacle, key, findings);
  check_breaks(cell, geometry, index, key, findings);
  if (speed > slowest_arm) {
    findings.push_back({Severity::kWarning, key + " reaches " + number_text(speed) +
                                                " m/s, but an arm's tool at most " + number_text(slowest_arm) +
                                                " m/s: it cannot always be avoided"});
  }
}

}  // namespace

void check_obstacles(const planner::Cell& cell, Findings& findings) {
  const auto& obstacles = cell.scene.obstacles;
  if (std::none_of(obstacles.begin(), obstacles.end(),
                   [](const auto& one) { return world::is_scripted(one.motion); })) {
    return;
  }
  std::vector<planner::Arm> models;
  double slowest = std::numeric_limits<double>::infinity();
  for (const auto& planned : cell.arms) {
    models.push_back(planned.arm);
    slowest = std::min(slowest, top_tool_speed(planned.arm));
  }
  planner::CellGeometry geometry(models, 0);
  geometry.set_obstacles(obstacles);
  const Bodies fixed = fixed_parts(cell, geometry);
  for (int i = 0; i < static_cast<int>(obstacles.size()); ++i) {
    if (world::is_scripted(obstacles[i].motion)) check_one(cell, geometry, i, fixed, slowest, findings);
  }
}

}  // namespace hecaton::config
