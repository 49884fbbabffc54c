#include <algorithm>
#include <limits>
#include <numbers>
#include <variant>

#include "planner/local/random.hpp"
#include "planner/model/kinematics.hpp"
#include "services/config/findings.hpp"
#include "services/config/overlaps.hpp"
#include "services/config/text.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::config {
namespace {

constexpr int kSpeedSamples = 300;
constexpr int kSweeps = 4;

/// Random joint positions within the limits and ±π.
void sample_joints(const planner::JointLimits& limits, planner::Random& random, planner::JointVector& q) {
  for (int joint = 0; joint < q.size(); ++joint) {
    q[joint] = random.uniform(std::max(limits.lower[joint], -std::numbers::pi),
                              std::min(limits.upper[joint], std::numbers::pi));
  }
}

// The maximum of ‖J q̇‖ over the box |q̇ⱼ| ≤ vⱼ lies in a corner: ascend from corner to corner along the last direction.
double fastest(const Eigen::Matrix3Xd& J, const planner::JointVector& velocity, const Eigen::Vector3d& first) {
  Eigen::Vector3d direction = first;
  double speed = 0.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    for (int joint = 0; joint < velocity.size(); ++joint) {
      v += J.col(joint) * (J.col(joint).dot(direction) < 0.0 ? -velocity[joint] : velocity[joint]);
    }
    speed = v.norm();
    if (speed <= 0.0) break;
    direction = v / speed;
  }
  return speed;
}

}  // namespace

double top_tool_speed(const planner::Arm& arm) {
  const planner::RobotModel& model = *arm.model;
  planner::Random random(1);
  planner::Kinematics kinematics;
  planner::FrameJacobian J;
  planner::JointVector q(model.joints());
  double top = 0.0;
  for (int sample = 0; sample < kSpeedSamples; ++sample) {
    sample_joints(arm.limits, random, q);
    planner::forward_kinematics(model, arm.X_WB, q, kinematics);
    planner::tool_jacobian(model, kinematics, J);
    const Eigen::Matrix3Xd linear = J.bottomRows<3>();
    for (int axis = 0; axis < 3; ++axis) {
      top = std::max(top, fastest(linear, arm.limits.velocity, Eigen::Vector3d::Unit(axis)));
    }
  }
  return top;
}

namespace {

using Bodies = std::vector<PosedBody>;

std::string apart_text(const NearestPair& pair) {
  if (pair.distance < 0.0) return overlap_text(pair);
  return pair.a + " and " + pair.b + " are " + number_text(pair.distance * 1e3) + " mm apart";
}

void add(const std::string& key, const NearestPair& pair, double needed, const std::string& consequence,
         Findings& findings) {
  warn(findings, key + ": " + apart_text(pair) + ", nearer than the security distance of " + number_text(needed * 1e3) +
                     " mm: " + consequence);
}

Bodies standing_obstacles(const planner::Cell& cell, const planner::CellGeometry& geometry) {
  Bodies bodies;
  for (int i = 0; i < static_cast<int>(cell.scene.obstacles.size()); ++i) {
    if (!std::holds_alternative<world::StaticMotion>(cell.scene.obstacles[i].motion)) continue;
    for (PosedBody& body : place_obstacle(geometry, cell.scene.obstacles[i], i)) bodies.push_back(std::move(body));
  }
  return bodies;
}

void check_poses(const planner::Cell& cell, const planner::CellGeometry& geometry, int arm, const Bodies& standing,
                 Findings& findings) {
  const planner::PlannedArm& planned = cell.arms[arm];
  const planner::DamperParameters& damper = planned.parameters.damper;
  const std::string consequence = "the dampers keep the arm from reaching it";
  for (const auto& [name, q] : planned.arm.named) {
    const std::string key = arm_key(arm) + ".poses." + name;
    const Bodies bodies = place_arm(cell.scene.obstacles, geometry, arm, q);
    const NearestPair self = nearest_self_pair(bodies, geometry, damper.self_security_distance);
    if (self.found) add(key, self, damper.self_security_distance, consequence, findings);
    const NearestPair obstacle = nearest_pair(bodies, standing, damper.security_distance, true);
    if (obstacle.found) add(key, obstacle, damper.security_distance, consequence, findings);
  }
}

/// All arms in these poses at the same time.
void check_apart(const planner::Cell& cell, const planner::CellGeometry& geometry,
                 const std::vector<planner::JointVector>& poses, const std::string& key, const std::string& consequence,
                 Findings& findings) {
  std::vector<Bodies> arms;
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    arms.push_back(place_arm(cell.scene.obstacles, geometry, arm, poses[arm]));
    for (int other = 0; other < arm; ++other) {
      const double needed = std::max(cell.arms[arm].parameters.damper.security_distance,
                                     cell.arms[other].parameters.damper.security_distance);
      const NearestPair pair =
          nearest_pair_of_arms(cell.arms[arm].arm, arms[arm], cell.arms[other].arm, arms[other], needed);
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
  check_apart(cell, geometry, starts, "", "the dampers move both arms apart", findings);
  for (std::size_t stop = 0; stop < cell.tasks.pose_sequence.size(); ++stop) {
    std::vector<planner::JointVector> poses;
    for (const auto& planned : cell.arms) poses.push_back(planned.arm.named.at(cell.tasks.pose_sequence[stop]));
    const std::string key = "tasks.pose_sequence[" + std::to_string(stop) + "] = " + cell.tasks.pose_sequence[stop];
    check_apart(cell, geometry, poses, key, "the dampers keep the arms from reaching it together", findings);
  }
}

namespace {

constexpr double kWatched = 60.0;  // the checked part of a script [s]
constexpr int kScriptSamples = 600;
constexpr int kConfigurations = 200;   // of each arm, to decide whether it reaches an obstacle
constexpr double kSuddenChange = 0.1;  // a larger jump of velocity exceeds dampers and margins [m/s]

Bodies fixed_parts(const planner::Cell& cell, const planner::CellGeometry& geometry) {
  Bodies fixed;
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    for (PosedBody& body : place_arm(cell.scene.obstacles, geometry, arm, cell.arms[arm].start)) {
      if (!body.body.moves) fixed.push_back(std::move(body));
    }
  }
  return fixed;
}

// docs/explanation/0010-passing-obstacles.md: arms assume a bound on the acceleration of obstacles.
void check_acceleration(const planner::Cell& cell, const world::Obstacle& obstacle, const std::string& key,
                        Findings& findings) {
  const double needed = world::greatest_acceleration(obstacle);
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    const double allowed = cell.arms[arm].parameters.acceleration_of_obstacles;
    if (needed <= allowed) continue;
    warn(findings, key + " accelerates by up to " + number_text(needed) + " m/s², more than " + arm_key(arm) +
                       ".acceleration_of_obstacles = " + number_text(allowed) +
                       ": the arm underestimates how near the obstacle may come");
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
    sample_joints(planned.arm.limits, random, q);
    const Bodies bodies = place_arm(cell.scene.obstacles, geometry, arm, q);
    if (nearest_pair(bodies, obstacle, planned.parameters.damper.influence_distance, true).found) return true;
  }
  return false;
}

/// An arm cannot avoid an obstacle that jumps, or whose velocity jumps, where the arm may be.
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
      warn(findings, key + what + " at " + point_text(one.X_WO.translation()) + ", within reach of " + arm_key(arm) +
                         ": an arm that is there cannot avoid it in time");
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
  for (int sample = 0; sample < kScriptSamples; ++sample) {
    const world::MotionState state = world::motion_at(obstacle, kWatched * sample / kScriptSamples);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      bodies[i].X_WS = state.X_WO * geometry.obstacle_bodies(index)[i].X_CS;
    }
    speed = std::max(speed, state.velocity.linear.norm());
    const NearestPair pair = nearest_pair(fixed, bodies, deepest.found ? deepest.distance : 0.0, false);
    if (pair.found) deepest = pair;
  }
  if (deepest.found) {
    warn(findings, key + " passes through a part that no joint moves: " + overlap_text(deepest));
  }
  check_acceleration(cell, obstacle, key, findings);
  check_breaks(cell, geometry, index, key, findings);
  if (speed > slowest_arm) {
    warn(findings, key + " reaches " + number_text(speed) + " m/s, but an arm's tool at most " +
                       number_text(slowest_arm) + " m/s: it cannot always be avoided");
  }
}

}  // namespace

void check_obstacles(const planner::Cell& cell, Findings& findings) {
  const auto& obstacles = cell.scene.obstacles;
  if (std::none_of(obstacles.begin(), obstacles.end(),
                   [](const auto& one) { return world::is_scripted(one.motion); })) {
    return;
  }
  double slowest = std::numeric_limits<double>::infinity();
  for (const auto& planned : cell.arms) slowest = std::min(slowest, top_tool_speed(planned.arm));
  planner::CellGeometry geometry(arms_of(cell), 0);
  geometry.set_obstacles(obstacles);
  const Bodies fixed = fixed_parts(cell, geometry);
  for (int i = 0; i < static_cast<int>(obstacles.size()); ++i) {
    if (world::is_scripted(obstacles[i].motion)) check_one(cell, geometry, i, fixed, slowest, findings);
  }
}

}  // namespace hecaton::config
