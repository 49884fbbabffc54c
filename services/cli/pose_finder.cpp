#include "services/cli/pose_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "planner/cell_defaults.hpp"
#include "planner/local/default_damper.hpp"
#include "planner/model/kinematics.hpp"

namespace hecaton::services::cli {
namespace {

using planner::JointVector;

/// Clearances to other arms and obstacles that a chosen pose should have, the widest first [m].
constexpr std::array<double, 4> kWanted = {0.08, 0.05, 0.03, 0.015};
/// Links of the arm keep this much more than the security distance in a chosen pose, as in goals that `simulate` draws
/// [m].
constexpr double kMarginOfItself = 0.015;
constexpr double kLeastMarginOfItself = 0.002;  ///< the same for arms that have no such pose [m]
/// Clearance to other arms and obstacles with which a robot's own pose is taken [m].
constexpr double kOwnPoseClearance = 0.03;
/// Least way of a link or the tool from `home` to another pose, as a share of the width at `home`: one that is seen.
constexpr double kApart = 0.4;
constexpr double kApartInJoints = 0.5;  ///< the same in joint space, for arms without such a pose [rad | m]
constexpr double kPlainAngle = 0.25 * std::numbers::pi;  ///< chosen poses have multiples of it where they can [rad]
constexpr double kPlainLength = 0.05;                    ///< the same of sliding joints [m]
constexpr double kWider = 1.05;                          ///< a plainer pose may be wider by this factor

planner::Kinematics at(const planner::Arm& model, const JointVector& q) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(*model.model, model.X_WB, q, kinematics);
  return kinematics;
}

/// The greatest distance of a link or the tool from the base [m].
double width(const planner::Arm& model, const JointVector& q) {
  const planner::Kinematics kinematics = at(model, q);
  double farthest = (kinematics.X_WT.translation() - model.X_WB.translation()).norm();
  for (int link = 0; link < kinematics.links; ++link) {
    farthest = std::max(farthest, (kinematics.X_WL[link].translation() - model.X_WB.translation()).norm());
  }
  return farthest;
}

/// The greatest distance of the origin of a link or of the tool between two poses [m].
double way(const planner::Arm& model, const JointVector& from, const JointVector& to) {
  const planner::Kinematics start = at(model, from);
  const planner::Kinematics end = at(model, to);
  double farthest = (end.X_WT.translation() - start.X_WT.translation()).norm();
  for (int link = 0; link < end.links; ++link) {
    farthest = std::max(farthest, (end.X_WL[link].translation() - start.X_WL[link].translation()).norm());
  }
  return farthest;
}

/// Moves joints to zero, or to round positions, where the pose still fits and is not wider.
JointVector plain(const planner::Arm& model, JointVector q, const auto& fits) {
  const double widest = kWider * width(model, q);
  for (const planner::Link& link : model.model->links) {
    if (link.joint < 0) continue;
    const double step = link.joint_type == planner::JointType::kPrismatic ? kPlainLength : kPlainAngle;
    const double found = q[link.joint];
    for (const double position : {0.0, std::round(found / step) * step}) {
      q[link.joint] = position;
      const bool within = position >= model.limits.lower[link.joint] && position <= model.limits.upper[link.joint];
      if (within && width(model, q) <= widest && fits(q)) break;
      q[link.joint] = found;
    }
  }
  return q;
}

}  // namespace

PoseFinder::PoseFinder(const std::vector<planner::Arm>& arms, std::vector<world::Obstacle> obstacles)
    : obstacles_(std::move(obstacles)) {
  for (std::size_t i = 0; i < arms.size(); ++i) {
    geometries_.emplace_back(arms, static_cast<int>(i));
    geometries_.back().set_obstacles(obstacles_);
    postures_.push_back(planner::compact_postures(arms[i]));
  }
}

std::optional<std::vector<JointVector>> PoseFinder::find(const std::vector<planner::Arm>& arms,
                                                         const std::string& name) const {
  std::vector<JointVector> poses;
  Placed placed;
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const auto pose = find_one(arms[i], static_cast<int>(i), name, placed);
    if (!pose) return std::nullopt;
    placed.push_back(bodies(static_cast<int>(i), *pose));
    poses.push_back(*pose);
  }
  return poses;
}

std::vector<config::PosedBody> PoseFinder::bodies(int arm, const JointVector& q) const {
  return config::place_arm(obstacles_, geometries_[arm], arm, q);
}

bool PoseFinder::clear(int arm, const JointVector& q, const Placed& placed, const Wanted& wanted) const {
  const planner::CellGeometry& geometry = geometries_[arm];
  const auto own = bodies(arm, q);
  if (config::nearest_self_pair(own, geometry, wanted.of_itself, wanted.share).found) return false;
  for (int i = 0; i < static_cast<int>(obstacles_.size()); ++i) {
    const auto obstacle = config::place_obstacle(geometry, obstacles_[i], i);
    if (config::nearest_pair(own, obstacle, wanted.of_others, true).found) return false;
  }
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const auto& arms = geometry.arms();
    const planner::Arm& own_arm = arms[static_cast<std::size_t>(arm)];
    if (config::nearest_pair_of_arms(own_arm, own, arms[i], placed[i], wanted.of_others).found) return false;
  }
  return true;
}

std::optional<JointVector> PoseFinder::find_one(const planner::Arm& model, int arm, const std::string& name,
                                                const Placed& placed) const {
  if (const auto own = model.named.find(name); own != model.named.end()) {
    if (clear(arm, own->second, placed, {0.0, planner::kSecurityShare, kOwnPoseClearance})) return own->second;
  }
  const auto home = model.named.find("home");
  const bool any = name == "home" || home == model.named.end();
  const auto seen = [&](const JointVector& q) {
    return any || way(model, home->second, q) >= kApart * width(model, home->second);
  };
  const auto apart = [&](const JointVector& q) { return any || (q - home->second).norm() >= kApartInJoints; };
  // Next to the security distance an arm comes to rest slowly, within it not at all: a pose that is seen less is
  // better.
  using Usable = std::function<bool(const JointVector&)>;
  for (const Usable& usable : {Usable(seen), Usable(apart)}) {
    for (const double margin : {kMarginOfItself, kLeastMarginOfItself}) {
      if (auto pose = find_compact(model, arm, placed, usable, margin)) return pose;
    }
  }
  if (auto pose = find_compact(model, arm, placed, seen, std::nullopt)) return pose;
  return find_compact(model, arm, placed, apart, std::nullopt);
}

std::optional<JointVector> PoseFinder::find_compact(const planner::Arm& model, int arm, const Placed& placed,
                                                    const std::function<bool(const JointVector&)>& usable,
                                                    std::optional<double> margin) const {
  const auto posture = [&](const Wanted& wanted) -> std::optional<JointVector> {
    const auto fits = [&](const JointVector& q) { return usable(q) && clear(arm, q, placed, wanted); };
    const auto found = std::find_if(postures_[arm].begin(), postures_[arm].end(), fits);
    if (found == postures_[arm].end()) return std::nullopt;
    return plain(model, *found, fits);
  };
  const double kept = planner::default_damper({.reach = planner::arm_reach(model).tool}).self_security_distance;
  for (const double clearance : kWanted) {
    const Wanted wanted = margin ? Wanted{kept + *margin, planner::kRestShare, clearance}
                                 : Wanted{0.25 * clearance, planner::kSecurityShare, clearance};
    if (auto pose = posture(wanted)) return pose;
  }
  return std::nullopt;
}

}  // namespace hecaton::services::cli
