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
constexpr int kReachSamples = 20000;  ///< of one arm
constexpr int kLeastReachSamples = 2000;
constexpr int kAllReachSamples = 80000;  ///< of all arms, if that leaves enough for each
/// At most this many times as many samples of an arm of larger reach than the shortest.
constexpr double kMostTimesSamples = 25.0;
/// Edge of the voxels that compare the reach of arms, as a share of the shortest reach.
constexpr double kVoxel = 0.125;
constexpr std::size_t kLeastVoxels = 4;
/// Of the voxels of an assumed task area all arms reach this share at least. Samples miss some that arms reach.
constexpr double kCommonShare = 0.9;
constexpr double kFlatness = 0.7;    ///< half height over radius
constexpr double kMeanWeight = 0.1;  ///< of the distance from the mean against the radius
constexpr double kEqual = 1e-9;      ///< cylinders whose values differ by less are equal [voxels]
constexpr double kInside = 0.85;     ///< used share of the radius

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

using Voxel = std::array<long, 3>;  ///< integer coordinates

/// Voxels of equal size that the tools of all arms reach, in W or in the base frame of each arm.
struct CommonReach {
  double edge = 0.0;  ///< [m]
  std::vector<Voxel> voxels;
};

/// Positions of the arm's tool in postures within the limits, with its base at X_WB [m].
std::vector<Eigen::Vector3d> sample_tool(const Arm& arm, const Pose& X_WB, int samples) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(samples);
  Kinematics kinematics;
  Random random(1);
  for (int sample = 0; sample < samples; ++sample) {
    forward_kinematics(*arm.model, X_WB, draw(arm.limits, random), kinematics);
    points.push_back(kinematics.X_WT.translation());
  }
  return points;
}

/// Samples of each arm: as many in each voxel of a long arm's reach as of the shortest arm's, else the long arm's are
/// too few to fill the voxels that it reaches.
std::vector<int> samples_of_arms(const Cell& cell) {
  const int arms = std::max(1, static_cast<int>(cell.arms.size()));
  const int samples = std::clamp(kAllReachSamples / arms, kLeastReachSamples, kReachSamples);
  std::vector<double> reach;
  for (const PlannedArm& planned : cell.arms) reach.push_back(std::max(1e-3, arm_reach(planned.arm).tool));
  const double shortest = reach.empty() ? 1.0 : *std::min_element(reach.begin(), reach.end());
  std::vector<int> counts;
  for (const double length : reach) {
    const double times = std::clamp(std::floor(std::pow(length / shortest, 3)), 1.0, kMostTimesSamples);
    counts.push_back(samples * static_cast<int>(times));
  }
  return counts;
}

using ToolPoints = std::vector<std::vector<Eigen::Vector3d>>;  ///< of each arm

CommonReach common_reach(const Cell& cell, const ToolPoints& points, double lowest) {
  CommonReach reach;
  reach.edge = std::numeric_limits<double>::infinity();
  for (const PlannedArm& planned : cell.arms) {
    reach.edge = std::min(reach.edge, std::max(1e-3, kVoxel * arm_reach(planned.arm).tool));
  }
  std::map<Voxel, std::size_t> arms_before;  // voxels that each arm so far reaches: their number
  for (std::size_t i = 0; i < cell.arms.size(); ++i) {
    for (const Eigen::Vector3d& point : points[i]) {
      if (point.z() < lowest) continue;
      const Eigen::Vector3d p = point / reach.edge;
      const Voxel voxel{std::lround(p.x()), std::lround(p.y()), std::lround(p.z())};
      if (i == 0) arms_before.emplace(voxel, 0);
      const auto found = arms_before.find(voxel);
      if (found != arms_before.end() && found->second == i) ++found->second;
    }
  }
  for (const auto& [voxel, arms] : arms_before) {
    if (arms == cell.arms.size()) reach.voxels.push_back(voxel);
  }
  return reach;
}

/// To whole millimetres [m].
double rounded(double value) {
  return 1e-3 * std::round(1e3 * value);
}

/// Finds the greatest cylinder along z that all arms reach.
class CylinderSearch {
 public:
  explicit CylinderSearch(const CommonReach& reach) : reach_(reach), lower_(reach.voxels[0]), upper_(lower_) {
    for (const Voxel& voxel : reach.voxels) {
      for (int k = 0; k < 3; ++k) {
        lower_[k] = std::min(lower_[k], voxel[k]);
        upper_[k] = std::max(upper_[k], voxel[k]);
      }
      mean_ += point(voxel) / static_cast<double>(reach.voxels.size());
    }
    flatness_ = lower_[2] == upper_[2] ? 0.0 : kFlatness;
    common_.resize(size(0) * size(1) * size(2), false);
    for (const Voxel& voxel : reach.voxels) common_[index(voxel)] = true;
    sort_offsets();
  }

  /// The greatest; of equals, that nearest to the mean of the voxels. Between equal neighbours it stands in the middle,
  /// because an even number of voxels has no middle one.
  [[nodiscard]] TaskArea find() const {
    double greatest = -std::numeric_limits<double>::infinity();
    std::vector<Eigen::Vector3d> middles;  // of equal cylinders, neighbours of the first
    double voxels = 0.0;                   // radius of the cylinder
    for (const Voxel& middle : reach_.voxels) {
      const double radius = radius_at(middle);
      const double value = radius - kMeanWeight * (point(middle) - mean_).norm();
      if (value > greatest + kEqual) {
        greatest = value;
        voxels = radius;
        middles = {point(middle)};
      } else if (value >= greatest - kEqual && (point(middle) - middles[0]).lpNorm<Eigen::Infinity>() <= 1.0) {
        middles.push_back(point(middle));
      }
    }
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& middle : middles) centre += middle / static_cast<double>(middles.size());
    TaskArea area;
    area.centre = (reach_.edge * centre).unaryExpr(&rounded);
    area.radius = std::max(1e-3, rounded(kInside * reach_.edge * (voxels + 0.5)));  // half a voxel: the middle one
    area.half_height = rounded(flatness_ * area.radius);
    return area;
  }

 private:
  [[nodiscard]] static Eigen::Vector3d point(const Voxel& voxel) {
    return {static_cast<double>(voxel[0]), static_cast<double>(voxel[1]), static_cast<double>(voxel[2])};
  }
  [[nodiscard]] std::size_t size(int k) const { return static_cast<std::size_t>(upper_[k] - lower_[k] + 1); }
  [[nodiscard]] std::size_t index(const Voxel& voxel) const {
    return (static_cast<std::size_t>(voxel[0] - lower_[0]) * size(1) + (voxel[1] - lower_[1])) * size(2) +
           (voxel[2] - lower_[2]);
  }
  [[nodiscard]] bool common(const Voxel& voxel) const {
    for (int k = 0; k < 3; ++k) {
      if (voxel[k] < lower_[k] || voxel[k] > upper_[k]) return false;
    }
    return common_[index(voxel)];
  }

  void sort_offsets() {
    const auto most = static_cast<long>(std::max(size(0), size(1)) / 2);
    const long height = std::lround(std::floor(flatness_ * static_cast<double>(most)));
    for (long x = -most; x <= most; ++x) {
      for (long y = -most; y <= most; ++y) {
        for (long z = -height; z <= height; ++z) {
          const double across = std::hypot(x, y);
          const double along = z == 0 ? 0.0 : static_cast<double>(std::abs(z)) / flatness_;
          const double radius = std::max(across, along);
          if (radius <= static_cast<double>(most)) offsets_.push_back({radius, {x, y, z}});
        }
      }
    }
    std::sort(offsets_.begin(), offsets_.end(), [](const Offset& a, const Offset& b) { return a.radius < b.radius; });
  }

  /// The greatest radius of a cylinder around the voxel of which all arms reach kCommonShare [voxels].
  [[nodiscard]] double radius_at(const Voxel& middle) const {
    double greatest = 0.0;
    int reached = 0;
    for (std::size_t i = 0; i < offsets_.size(); ++i) {
      const Voxel& offset = offsets_[i].voxel;
      reached += common({middle[0] + offset[0], middle[1] + offset[1], middle[2] + offset[2]}) ? 1 : 0;
      const bool whole = i + 1 == offsets_.size() || offsets_[i + 1].radius > offsets_[i].radius;
      if (whole && reached >= kCommonShare * static_cast<double>(i + 1)) greatest = offsets_[i].radius;
    }
    return greatest;
  }

  struct Offset {
    double radius;  ///< of the smallest cylinder with it [voxels]
    Voxel voxel;
  };

  const CommonReach& reach_;
  Voxel lower_;  ///< of the box around the voxels
  Voxel upper_;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();  ///< [voxels]
  double flatness_ = 0.0;                           ///< half height over radius; 0: all voxels are in one layer
  std::vector<bool> common_;
  std::vector<Offset> offsets_;  ///< by radius
};

/// Lowers top and raises bottom to the heights that all arms reach above the disc.
void limit_height(const ToolPoints& points, double lowest, TaskArea& area) {
  double bottom = std::max(lowest, area.centre.z() - area.half_height);
  double top = area.centre.z() + area.half_height;
  for (const std::vector<Eigen::Vector3d>& of_arm : points) {
    double least = std::numeric_limits<double>::infinity();
    double most = -least;
    for (const Eigen::Vector3d& point : of_arm) {
      if ((point - area.centre).head<2>().norm() > area.radius) continue;
      least = std::min(least, point.z());
      most = std::max(most, point.z());
    }
    bottom = std::max(bottom, least);
    top = std::min(top, most);
  }
  const double half_height = 0.5 * (top - bottom);
  if (half_height < 0.0 || half_height > area.half_height - 1e-3) return;
  area.centre.z() = rounded(bottom + half_height);
  area.half_height = std::floor(1e3 * half_height) * 1e-3;
}

/// The area in the common reach of all arms; empty if there is none.
std::optional<TaskArea> area_within(const Cell& cell, const ToolPoints& points, double lowest) {
  const CommonReach reach = common_reach(cell, points, lowest);
  if (reach.voxels.size() < kLeastVoxels) return std::nullopt;
  TaskArea area = CylinderSearch(reach).find();
  limit_height(points, lowest, area);
  return area;
}

}  // namespace

std::optional<TaskArea> default_task_area(const Cell& cell) {
  constexpr double kAnyHeight = -std::numeric_limits<double>::infinity();
  const std::vector<int> samples = samples_of_arms(cell);
  ToolPoints points;
  for (std::size_t i = 0; i < cell.arms.size(); ++i) {
    points.push_back(sample_tool(cell.arms[i].arm, cell.arms[i].arm.X_WB, samples[i]));
  }
  std::optional<TaskArea> area = area_within(cell, points, kAnyHeight);
  const auto stands = [&](const PlannedArm& planned) {
    return planned.arm.X_WB.translation().z() >= cell.scene.floor_z;
  };
  const double floor = cell.scene.floor_z;
  if (area && area->centre.z() - area->half_height < floor && std::all_of(cell.arms.begin(), cell.arms.end(), stands)) {
    if (const auto above = area_within(cell, points, floor)) area = above;
  }
  if (area) return area;
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = sample_tool(cell.arms[i].arm, Pose::Identity(), samples[i]);
  area = area_within(cell, points, kAnyHeight);
  if (area) area->of_each_arm = true;
  return area;
}

}  // namespace hecaton::planner
