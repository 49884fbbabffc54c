#include "planner/simulation/rest_clearance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "planner/collision/own_shapes.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::planner {
namespace {

/// Starts and goals keep this much more than the security distance dₛ, so that the velocity dampers let the arm rest
/// [m].
constexpr double kRestMargin = 0.03;
/// Largest motion of a point of a scripted obstacle between two samples of its script [m]. Between samples the distance
/// is smaller by at most half of that, less than kRestMargin.
constexpr double kSweepStep = 0.04;
constexpr int kMostSweepSamples = 2000;
/// Samples of a script from which the largest speed is taken.
constexpr int kSpeedSamples = 64;
/// Positions of the first joint at which links that only it moves are compared with static obstacles.
constexpr int kFirstJointSamples = 32;
constexpr int kMostNearPairs = 64;  ///< pairs of bodies that are compared in one posture
/// How much deeper than necessary a capsule of a body that is apart may reach into an obstacle [m].
constexpr double kCapsuleDepth = 1e-4;
constexpr std::span<const int> kNoArms;

bool of_arms(const Clearance& pair) {
  return pair.counterpart == Counterpart::kArm;
}

/// The only joint that moves `link`; −1: none, or more than one.
int only_joint(const RobotModel& model, int link) {
  int only = -1;
  for (; link >= 0; link = model.links[link].parent) {
    const int joint = model.links[link].joint;
    if (joint < 0 || joint == only) continue;
    if (only >= 0) return -1;
    only = joint;
  }
  return only;
}

bool moves_a_link_alone(const RobotModel& model, int joint) {
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link) {
    if (only_joint(model, link) == joint) return true;
  }
  return false;
}

/// Number of samples of the obstacle's script that satisfies kSweepStep.
int sweep_samples(const world::Obstacle& obstacle) {
  const double period = world::script_period(obstacle);
  double radius = 0.0;
  for (const world::PlacedShape& placed : obstacle.shapes) {
    const world::BoundingSphere ball = world::bounding_sphere(placed.shape);
    radius = std::max(radius, (placed.X_BS * ball.centre).norm() + ball.radius);
  }
  double fastest = 0.0;
  for (int k = 0; k < kSpeedSamples; ++k) {
    const world::Twist velocity = world::motion_at(obstacle, period * k / kSpeedSamples).velocity;
    fastest = std::max(fastest, velocity.linear.norm() + velocity.angular.norm() * radius);
  }
  return std::clamp(static_cast<int>(std::ceil(period * fastest / kSweepStep)), 1, kMostSweepSamples);
}

}  // namespace

// True if a pair of arm i that `counts` selects is nearer than `within`; found_ begins with it.
template <class Counts>
bool RestClearance::near(int i, const InfluenceDistances& within, std::span<const world::ObstacleState> obstacles,
                         const Counts& counts) {
  const int count = distances_[i].clearances({&kinematics_[i], kinematics_, obstacles}, within, found_);
  const auto end = found_.begin() + count;
  const auto first = std::find_if(found_.begin(), end, counts);
  if (first == end) return false;
  std::iter_swap(found_.begin(), first);
  return true;
}

RestClearance::RestClearance(const Cell& cell)
    : cell_(cell), kinematics_(cell.arms.size()), obstructions_(cell.arms.size()) {
  const std::vector<Arm> arms = arms_of(cell);
  for (int i = 0; i < this->arms(); ++i) geometries_.emplace_back(arms, i).set_obstacles(cell.scene.obstacles);
  for (const CellGeometry& geometry : geometries_) distances_.emplace_back(geometry);
  for (const CellGeometry& geometry : geometries_) {
    for (int other = 0; other < geometry.self(); ++other) can_meet_ = can_meet_ || geometry.gap_to_arm(other) < 0.0;
  }
  sweep_obstacles();
  for (int i = 0; i < this->arms(); ++i) always_near_.push_back(pairs_always_near(i));
}

bool RestClearance::clear_alone(int i, const JointVector& q) {
  place(i, q);
  const double distance = rest_distance(i);
  const double self_distance = cell_.arms[i].parameters.damper.self_security_distance + 0.5 * kRestMargin;
  const auto alone = [&](const Clearance& c) { return !of_arms(c) && !unavoidably_near(i, c); };
  for (const auto& states : sweep_) {
    const InfluenceDistances rest{
        .others = distance, .self = self_distance, .near_arms = kNoArms, .self_share = kRestShare};
    if (!near(i, rest, states, alone)) continue;
    count_obstruction(i, distance, self_distance);
    return false;
  }
  return true;
}

bool RestClearance::clear_of(int i, const JointVector& q, std::span<const int> others) {
  place(i, q);
  return !near(i, {.others = rest_distance(i), .self = 0.0, .near_arms = others}, sweep_.front(), of_arms);
}

bool RestClearance::clear_of_each_other(const CellConfiguration& q) {
  place(q);
  for (int i = 0; i < arms(); ++i) {
    if (near(i, {.others = rest_distance(i), .self = 0.0}, sweep_.front(), of_arms)) return false;
  }
  return true;
}

bool RestClearance::clear_at(double time, const CellConfiguration& q) {
  const std::vector<world::Obstacle>& obstacles = cell_.scene.obstacles;
  const auto passes = [&](const Clearance& c) {
    return c.counterpart == Counterpart::kObstacle && world::is_scripted(obstacles[c.other].motion);
  };
  std::vector<world::ObstacleState> states;
  for (const world::Obstacle& obstacle : obstacles) {
    const world::MotionState at = world::motion_at(obstacle, time);
    states.push_back({at.X_WO, at.velocity, 0.0});
  }
  place(q);
  for (int i = 0; i < arms(); ++i) {
    if (near(i, {.others = rest_distance(i), .self = 0.0, .near_arms = kNoArms}, states, passes)) return false;
  }
  return true;
}

bool RestClearance::stopped_alone(int i, const JointVector& q) {
  place(i, q);
  const auto stops = [&](const Clearance& c) { return !of_arms(c) && !unavoidably_near(i, c); };
  const double of_itself = cell_.arms[i].parameters.damper.self_security_distance;
  return near(i, {.others = 0.0, .self = of_itself, .near_arms = kNoArms, .self_share = kSecurityShare}, sweep_.front(),
              stops);
}

void RestClearance::note_touching(const CellConfiguration& q, bool obstacles, std::vector<bool>& touched) {
  const auto not_self = [](const Clearance& c) { return c.counterpart != Counterpart::kSelf; };
  bool (*const counts)(const Clearance&) = obstacles ? +not_self : &of_arms;
  place(q);
  for (int i = 0; i < arms(); ++i)
    touched[i] = touched[i] || near(i, {.others = 0.0, .self = 0.0}, sweep_.front(), counts);
}

const Pose& RestClearance::tool(int i, const JointVector& q) {
  place(i, q);
  return kinematics_[i].X_WT;
}

Obstruction RestClearance::most_frequent_obstruction(int i) const {
  Obstruction most;
  for (const auto& [pair, seen] : obstructions_[i]) {
    if (seen.draws > most.draws) most = seen;
  }
  return most;
}

void RestClearance::forget_obstructions() {
  obstructions_.assign(cell_.arms.size(), {});
}

void RestClearance::place(int i, const JointVector& q) {
  const Arm& arm = cell_.arms[i].arm;
  forward_kinematics(*arm.model, arm.X_WB, q, kinematics_[i]);
}

void RestClearance::place(const CellConfiguration& q) {
  for (int i = 0; i < arms(); ++i) place(i, q[i]);
}

double RestClearance::rest_distance(int i) const {
  const LocalParameters& p = cell_.arms[i].parameters;
  const double least = p.damper.security_distance + kRestMargin;
  return std::max(least, p.method->least_rest_distance().value_or(least));
}

// The largest distances of the bodies that one joint moves from static obstacles that they are near in every
// posture, such as the turning base of an arm from a floor. No goal has such a pair farther apart. The distance is
// negative when a capsule reaches into the obstacle; the bodies themselves are apart.
RestClearance::Widest RestClearance::pairs_always_near(int i) {
  const Arm& arm = cell_.arms[i].arm;
  Widest widest;
  std::array<Clearance, kMostNearPairs> near_pairs;
  std::set<std::array<int, 3>> touching;
  for (int joint = 0; joint < arm.model->joints(); ++joint) {
    if (!moves_a_link_alone(*arm.model, joint)) continue;
    const double lower = std::isfinite(arm.limits.lower[joint]) ? arm.limits.lower[joint] : -std::numbers::pi;
    const double upper = std::isfinite(arm.limits.upper[joint]) ? arm.limits.upper[joint] : std::numbers::pi;
    JointVector q = JointVector::Zero(arm.model->joints()).cwiseMax(arm.limits.lower).cwiseMin(arm.limits.upper);
    std::map<std::array<int, 3>, int> times;
    for (int k = 0; k < kFirstJointSamples; ++k) {
      q[joint] = lower + (upper - lower) * k / (kFirstJointSamples - 1);
      place(i, q);
      const CellPoses poses{&kinematics_[i], kinematics_, sweep_.front()};
      const int count =
          distances_[i].clearances(poses, {.others = rest_distance(i), .self = 0.0, .near_arms = kNoArms}, near_pairs);
      for (const Clearance& c : std::span(near_pairs).first(count)) {
        if (c.counterpart != Counterpart::kObstacle || only_joint(*arm.model, c.own_link) != joint) continue;
        if (!std::holds_alternative<world::StaticMotion>(cell_.scene.obstacles[c.other].motion)) continue;
        if (c.part > 0) continue;  // the pair's nearest points come first
        const std::array<int, 3> pair = {c.own_body, c.other, c.other_body};
        ++times[pair];
        double& distance = widest.try_emplace(pair, c.distance).first->second;
        distance = std::max(distance, c.distance);
        if (c.distance <= 0.0 && distance_of_own_shapes(geometries_[i], poses, c) <= 0.0) touching.insert(pair);
      }
    }
    std::erase_if(times, [](const auto& pair) { return pair.second == kFirstJointSamples; });
    for (const auto& [pair, _] : times) widest.erase(pair);
  }
  std::erase_if(widest, [&](const auto& pair) { return pair.second <= 0.0 && touching.contains(pair.first); });
  return widest;
}

// The pair is as near as its bodies are in every posture.
bool RestClearance::unavoidably_near(int i, const Clearance& pair) const {
  if (pair.counterpart != Counterpart::kObstacle) return false;
  const auto widest = always_near_[i].find({pair.own_body, pair.other, pair.other_body});
  if (widest == always_near_[i].end()) return false;
  const double least = widest->second > 0.0 ? kRestShare * widest->second : widest->second - kCapsuleDepth;
  return pair.distance >= least;
}

// Samples all scripts. All obstacles get as many samples as the one that needs most.
void RestClearance::sweep_obstacles() {
  const std::vector<world::Obstacle>& obstacles = cell_.scene.obstacles;
  std::vector<int> samples;
  for (const world::Obstacle& obstacle : obstacles) samples.push_back(sweep_samples(obstacle));
  const int most = samples.empty() ? 1 : *std::max_element(samples.begin(), samples.end());
  for (int k = 0; k < most; ++k) {
    std::vector<world::ObstacleState>& states = sweep_.emplace_back();
    for (std::size_t i = 0; i < obstacles.size(); ++i) {
      const double time = world::script_period(obstacles[i]) * k / samples[i];
      const world::MotionState at = world::motion_at(obstacles[i], time);
      states.push_back({at.X_WO, at.velocity, 0.0});
    }
  }
}

// Counts the pair that was too near in a draw of arm i: the first that near() found.
void RestClearance::count_obstruction(int i, double distance, double self_distance) {
  const Clearance& c = found_.front();
  const bool self = c.counterpart == Counterpart::kSelf;
  const CellGeometry& geometry = geometries_[i];
  Obstruction& seen = obstructions_[i][{self ? -1 : c.other, c.own_body, c.other_body}];
  if (seen.draws++ == 0) {
    seen.pair = geometry.own_name(c) + " and " + geometry.other_name(c);
    seen.of_self = self;
    seen.needed = self ? std::min(self_distance, kRestShare * geometry.widest(c.own_body, c.other_body)) : distance;
    seen.farthest = c.distance;
  }
  seen.farthest = std::max(seen.farthest, c.distance);
}

}  // namespace hecaton::planner
