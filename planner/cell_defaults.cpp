#include "planner/cell_defaults.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/random.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::planner {
namespace {

constexpr int kPostures = 400;
/// Links of one arm keep this distance in a chosen posture, where the arm has such postures [m].
constexpr double kSelfClearance = 0.05;
/// Weight of joints far from the middle of their range against a wide posture.
constexpr double kMiddleWeight = 0.1;
/// Chosen homes keep this much more than the security distance from everything else [m].
constexpr double kRestMargin = 0.03;
constexpr int kReachSamples = 3000;
/// Edge of the voxels that compare the reach of arms, as a share of the shortest reach.
constexpr double kVoxel = 0.2;
constexpr std::size_t kLeastVoxels = 4;

double lower_of(const JointLimits& limits, int joint) {
  return std::max(limits.lower[joint], std::min(-std::numbers::pi, limits.upper[joint] - 2.0 * std::numbers::pi));
}
double upper_of(const JointLimits& limits, int joint) {
  return std::min(limits.upper[joint], std::max(std::numbers::pi, limits.lower[joint] + 2.0 * std::numbers::pi));
}

JointVector draw(const JointLimits& limits, Random& random) {
  JointVector q(limits.lower.size());
  for (int j = 0; j < q.size(); ++j) q[j] = random.uniform(lower_of(limits, j), upper_of(limits, j));
  return q;
}

JointVector middle(const JointLimits& limits) {
  JointVector q(limits.lower.size());
  for (int j = 0; j < q.size(); ++j) q[j] = 0.5 * (lower_of(limits, j) + upper_of(limits, j));
  return q;
}

JointVector nearest_to_zero(const JointLimits& limits) {
  return JointVector::Zero(limits.lower.size()).cwiseMax(limits.lower).cwiseMin(limits.upper);
}

/// Small for compact postures whose joints are near the middle of their ranges.
double width(const Arm& arm, const ArmReach& reach, const std::vector<Body>& bodies, const Kinematics& kinematics,
             const JointVector& q) {
  double farthest = (kinematics.X_WT.translation() - reach.centre).norm();
  for (const Body& body : bodies) {
    if (!body.moves) continue;
    const Eigen::Vector3d centre_W = kinematics.X_WL[body.link] * body.bound.centre;
    farthest = std::max(farthest, (centre_W - reach.centre).norm());
  }
  double off_middle = 0.0;
  for (int j = 0; j < q.size(); ++j) {
    const double half = 0.5 * (upper_of(arm.limits, j) - lower_of(arm.limits, j));
    const double share = (q[j] - 0.5 * (upper_of(arm.limits, j) + lower_of(arm.limits, j))) / half;
    off_middle += share * share / static_cast<double>(q.size());
  }
  return farthest / std::max(reach.tool, 1e-3) + kMiddleWeight * off_middle;
}

std::vector<world::ObstacleState> states_at_start(const world::Scene& scene) {
  std::vector<world::ObstacleState> states;
  for (const world::Obstacle& obstacle : scene.obstacles) {
    const world::MotionState at = world::motion_at(obstacle, 0.0);
    states.push_back({at.X_WO, at.velocity, 0.0});
  }
  return states;
}

}  // namespace

std::vector<JointVector> compact_postures(const Arm& arm) {
  const CellGeometry geometry({arm}, 0);
  const ArmReach reach = arm_reach(arm);
  ExactDistance distance(geometry);
  std::vector<Kinematics> kinematics(1);
  std::vector<Clearance> found(1);
  std::vector<JointVector> candidates{middle(arm.limits), nearest_to_zero(arm.limits)};
  Random random(1);
  while (candidates.size() < kPostures) candidates.push_back(draw(arm.limits, random));
  for (const double clearance : {kSelfClearance, 0.0}) {
    std::vector<std::pair<double, JointVector>> clear;
    for (const JointVector& q : candidates) {
      forward_kinematics(*arm.model, arm.X_WB, q, kinematics[0]);
      const InfluenceDistances self{.self = clearance, .self_share = kRestShare};
      if (distance.clearances({kinematics.data(), kinematics, {}}, self, found) > 0) continue;
      clear.emplace_back(width(arm, reach, geometry.own_bodies(), kinematics[0], q), q);
    }
    if (clear.empty()) continue;
    std::stable_sort(clear.begin(), clear.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<JointVector> postures;
    for (auto& [cost, q] : clear) postures.push_back(std::move(q));
    return postures;
  }
  return {nearest_to_zero(arm.limits)};
}

void choose_home_poses(Cell& cell, std::span<const int> arms) {
  const std::vector<Arm> models = arms_of(cell);
  const std::vector<world::ObstacleState> obstacles = states_at_start(cell.scene);
  std::vector<Kinematics> kinematics(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    forward_kinematics(*models[i].model, models[i].X_WB, models[i].home(), kinematics[i]);
  }
  std::vector<Clearance> found(1);
  for (const int arm : arms) {
    PlannedArm& planned = cell.arms[arm];
    CellGeometry geometry(models, arm);
    geometry.set_obstacles(cell.scene.obstacles);
    ExactDistance distance(geometry);
    const double least = planned.parameters.damper.security_distance + kRestMargin;
    const bool starts_at_home = planned.start.size() == 0 || planned.start == planned.arm.home();
    const auto clear_of_others = [&](const JointVector& q) {
      forward_kinematics(*planned.arm.model, planned.arm.X_WB, q, kinematics[arm]);
      return distance.clearances({&kinematics[arm], kinematics, obstacles}, {.others = least, .self = 0.0}, found) == 0;
    };
    const std::vector<JointVector> postures = compact_postures(planned.arm);
    const auto chosen = std::find_if(postures.begin(), postures.end(), clear_of_others);
    if (chosen != postures.end()) planned.arm.named["home"] = *chosen;
    forward_kinematics(*planned.arm.model, planned.arm.X_WB, planned.arm.home(), kinematics[arm]);
    if (starts_at_home) planned.start = planned.arm.home();
  }
}

namespace {

/// Positions of the tools of all arms in one voxel.
struct Voxel {
  std::vector<bool> reached;  ///< by each arm
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
};

/// Mean positions in the voxels that every arm reaches, in W or in the base frame of each arm.
std::vector<Eigen::Vector3d> common_reach(const Cell& cell, bool of_each_arm) {
  double edge = std::numeric_limits<double>::infinity();
  for (const PlannedArm& planned : cell.arms) edge = std::min(edge, kVoxel * arm_reach(planned.arm).tool);
  edge = std::max(edge, 1e-3);
  std::map<std::array<long, 3>, Voxel> voxels;
  Kinematics kinematics;
  for (std::size_t i = 0; i < cell.arms.size(); ++i) {
    const Arm& arm = cell.arms[i].arm;
    const Pose X_WF = of_each_arm ? Pose::Identity() : arm.X_WB;
    Random random(1);
    for (int sample = 0; sample < kReachSamples; ++sample) {
      forward_kinematics(*arm.model, X_WF, draw(arm.limits, random), kinematics);
      const Eigen::Vector3d p = kinematics.X_WT.translation();
      Voxel& voxel = voxels[{std::lround(p.x() / edge), std::lround(p.y() / edge), std::lround(p.z() / edge)}];
      voxel.reached.resize(cell.arms.size(), false);
      voxel.reached[i] = true;
      voxel.sum += p;
      ++voxel.count;
    }
  }
  std::vector<Eigen::Vector3d> common;
  for (const auto& [index, voxel] : voxels) {
    const bool all = std::all_of(voxel.reached.begin(), voxel.reached.end(), [](bool reached) { return reached; });
    if (all) common.push_back(voxel.sum / voxel.count);
  }
  return common;
}

/// The cylinder along z with the same mean and about the same spread as the points.
TaskArea cylinder(const std::vector<Eigen::Vector3d>& points) {
  const auto count = static_cast<double>(points.size());
  const auto rounded = [](double value) { return 1e-3 * std::round(1e3 * value); };
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / count;
  double across = 0.0;
  double along = 0.0;
  for (const Eigen::Vector3d& p : points) {
    across += (p - mean).head<2>().squaredNorm() / count;
    along += (p - mean).z() * (p - mean).z() / count;
  }
  // A disc of radius R has the mean square R²/2, a height h above and below the middle h²/3. Slightly less keeps the
  // area away from the border of the reach.
  TaskArea area;
  area.centre = mean.unaryExpr(rounded);
  area.radius = std::max(1e-3, rounded(0.85 * std::sqrt(2.0 * across)));
  area.half_height = rounded(0.85 * std::sqrt(3.0 * along));
  return area;
}

}  // namespace

std::optional<TaskArea> default_task_area(const Cell& cell) {
  for (const bool of_each_arm : {false, true}) {
    const std::vector<Eigen::Vector3d> common = common_reach(cell, of_each_arm);
    if (common.size() < kLeastVoxels) continue;
    TaskArea area = cylinder(common);
    area.of_each_arm = of_each_arm;
    return area;
  }
  return std::nullopt;
}

}  // namespace hecaton::planner
