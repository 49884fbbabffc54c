#include "planner/local_scene.hpp"

#include <algorithm>
#include <cmath>

#include "planner/local/latency_compensation.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/simd/instruction_set.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// The bounding balls of an arm's bodies. Each tick places them.
std::vector<CarriedBall> carried_balls(const RobotModel& model, const Kinematics& kinematics,
                                       const std::vector<Body>& bodies) {
  std::vector<CarriedBall> balls;
  for (const Body& body : bodies) {
    CarriedBall& ball = balls.emplace_back();
    ball.X_WL = kinematics.X_WL[body.link].data();
    for (int i = 0; i < 3; ++i) ball.centre_L[i] = body.bound.centre[i];
    ball.radius = body.bound.radius;
    ball.axes = axes_before(model, body.link);
  }
  return balls;
}

/// Largest distance of a point of an obstacle from its origin [m].
double radius_of(const std::vector<Body>& bodies) {
  double reach = 0.0;
  for (const Body& body : bodies) reach = std::max(reach, body.bound.centre.norm() + body.bound.radius);
  return reach;
}

/// Bound of the speed of any point per unit joint rate, for revolute [m] and prismatic [1] joints. The axes of a joint
/// with followers move it together.
double longest_lever(const CellGeometry& geometry, int arm) {
  const RobotModel& model = *geometry.arms()[arm].model;
  JointVector gain = JointVector::Zero(model.joints());
  for (const Link& link : model.links) {
    if (link.joint >= 0) gain[link.joint] += std::abs(link.multiplier);
  }
  return std::max(1.0, 2.0 * geometry.arm_reach(arm).radius) * std::max(1.0, gain.maxCoeff());
}

/// Places an arm's balls and bounds the speed of their points for joint rates up to `speed`.
void bound_speeds(const RobotModel& model, const Kinematics& kinematics, const JointVector& speed,
                  std::vector<CarriedBall>& balls) {
  static const SpeedKernel kernel = fastest(baseline::bound_speeds, avx2::bound_speeds);
  const auto& w = kinematics.angular_W;
  const auto& v = kinematics.linear_W;
  std::array<double, kMaxJoints> speeds;
  axis_speeds(model, speed, speeds);
  kernel({{w[0].data(), w[1].data(), w[2].data()}, {v[0].data(), v[1].data(), v[2].data()}}, speeds.data(),
         balls.data(), static_cast<int>(balls.size()));
}

double fastest_point(const RobotModel& model, const Kinematics& kinematics, const JointVector& speed,
                     std::vector<CarriedBall>& balls) {
  bound_speeds(model, kinematics, speed, balls);
  double fastest = 0.0;
  for (const CarriedBall& ball : balls) fastest = std::max(fastest, ball.fastest);
  return fastest;
}

/// The same for an obstacle with points up to `radius` [m] from its origin.
double fastest_point(double radius, const world::Twist& velocity) {
  return velocity.linear.norm() + velocity.angular.norm() * radius;
}

/// The distance within which a row can bind: where the damper allows less than the largest approach speed of the pair,
/// or where it limits the stop time. `shares`: 2 when both arms keep half of the damper, else 1. `margin`: how much
/// nearer than expected the counterpart may be [m].
Reach reach_of(const Damper& damper, double margin, double speed_of_other, double shares) {
  const double nearest = margin + damper.security_distance;
  const double seconds = damper.longest();
  return {nearest + damper.convergence_speed * seconds, nearest + speed_of_other * seconds, shares * seconds};
}

/// How far a point body_uncertainty within `age` [s] from where it would be at constant velocity [m].
double position_uncertainty(double acceleration, double age) {
  return 0.5 * acceleration * age * age;
}

/// All obstacles have the same age and linear velocity and none turns: one reach then holds for all.
bool all_alike(std::span<const world::ObstacleState> states) {
  if (states.empty()) return true;
  const double age = states.front().age;
  const Eigen::Vector3d& v = states.front().velocity.linear;
  return std::all_of(states.begin(), states.end(), [&](const world::ObstacleState& state) {
    const Eigen::Vector3d& linear = state.velocity.linear;
    const Eigen::Vector3d& angular = state.velocity.angular;
    return state.age == age && linear.x() == v.x() && linear.y() == v.y() && linear.z() == v.z() &&
           angular.x() == 0.0 && angular.y() == 0.0 && angular.z() == 0.0;
  });
}

}  // namespace

LocalScene::LocalScene(const CellGeometry& geometry) : arms_(geometry.arms().size()) {
  rebuild(geometry);
}

void LocalScene::rebuild(const CellGeometry& geometry) {
  own_speed_.assign(geometry.own_bodies().size(), 0.0);
  gap_to_arm_.clear();
  lever_.clear();
  acceleration_.clear();
  stop_times_.clear();
  balls_of_arm_.clear();
  levers_.clear();
  body_uncertainty_.clear();
  longest_stop_ = fastest_other_ = strongest_other_ = 0.0;
  const double own_stop = longest_stop_time(geometry.own_arm().limits);
  for (int i = 0; i < static_cast<int>(geometry.arms().size()); ++i) {
    const JointLimits& limits = geometry.arms()[i].limits;
    const double lever = longest_lever(geometry, i);
    lever_.push_back(lever);
    acceleration_.push_back(limits.acceleration.sum() * lever);
    fastest_other_ = std::max(fastest_other_, limits.velocity.sum() * lever);
    strongest_other_ = std::max(strongest_other_, acceleration_.back());
    gap_to_arm_.push_back(geometry.gap_to_arm(i));
    stop_times_.push_back(std::max(own_stop, longest_stop_time(limits)));
    longest_stop_ = std::max(longest_stop_, stop_times_.back());
    const Kinematics& kinematics = i == geometry.self() ? own_ : arms_[i];
    balls_of_arm_.push_back(carried_balls(*geometry.arms()[i].model, kinematics, geometry.arm_bodies(i)));
    std::vector<JointVector>& levers = levers_.emplace_back();
    for (const Body& body : geometry.arm_bodies(i)) {
      levers.push_back(longest_levers(geometry.arms()[i], body.link, body.bound.centre.norm() + body.bound.radius));
    }
    body_uncertainty_.emplace_back(levers.size(), 0.0);
  }
  radius_of_obstacle_.clear();
  for (int i = 0; i < geometry.obstacle_count(); ++i) {
    radius_of_obstacle_.push_back(radius_of(geometry.obstacle_bodies(i)));
  }
  near_arms_.reserve(geometry.arms().size());
  observations_.resize(geometry.arms().size());
  reach_of_arm_.assign(geometry.arms().size(), {});
  extrapolated_.resize(geometry.obstacle_count());
  reach_of_obstacle_.assign(geometry.obstacle_count(), {});
}

void LocalScene::update(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                        const JointVector& fastest) {
  update_self(geometry, parameters, input, fastest);
  update_arms(geometry, parameters, input);
  update_obstacles(geometry, parameters, input);
}

InfluenceDistances LocalScene::influence() const {
  return {.own_speed = own_speed_,
          .of_arm = reach_of_arm_,
          .of_obstacle = std::span(reach_of_obstacle_).first(obstacle_reaches_),
          .of_self = reach_of_self_,
          .near_arms = std::span<const int>(near_arms_)};
}

DamperScene LocalScene::scene(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                              const ExactDistance& distances) const {
  return {geometry,       own_,     input.qd,   input.tracking_error, arms_,     observations_, stop_times_,
          obstacles_now_, input.dt, parameters, body_uncertainty_,    &distances};
}

void LocalScene::update_self(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                             const JointVector& fastest) {
  const Arm& arm = geometry.own_arm();
  std::vector<CarriedBall>& balls = balls_of_arm_[geometry.self()];
  forward_kinematics(*arm.model, arm.X_WB, input.q, own_);
  own_fastest_ = fastest_point(*arm.model, own_, fastest, balls);
  for (std::size_t i = 0; i < own_speed_.size(); ++i) own_speed_[i] = balls[i].fastest;
  reach_of_self_ = reach_of(parameters.damper.against_self(stop_times_[geometry.self()] + input.dt), 0.0, 0.0, 1.0);
}

/// Extrapolates every other arm in reach to now and computes its reach.
void LocalScene::update_arms(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input) {
  const double influence = farthest_influence(parameters, input.dt);
  near_arms_.clear();
  for (int i = 0; i < static_cast<int>(geometry.arms().size()); ++i) {
    if (i == geometry.self() || (gap_to_arm_[i] > influence && !input.arms[i].lost())) continue;
    if (!may_matter(geometry, parameters, i, input.arms[i], input.dt)) continue;
    near_arms_.push_back(i);
    const Arm& arm = geometry.arms()[i];
    ArmObservation& other = observations_[i] = input.arms[i];
    extrapolate(arm.limits, other);
    const bool row_ignores_its_motion = other.plans && other.age <= 0.0;
    (row_ignores_its_motion ? place_links : forward_kinematics)(*arm.model, arm.X_WB, other.q, arms_[i]);
    const auto fastest = [&](const JointVector& speed) {
      return fastest_point(*arm.model, arms_[i], speed, balls_of_arm_[i]);
    };
    const Damper damper = parameters.damper.against_others(stop_times_[i] + input.dt);
    const double margin = other.lost()      ? update_body_uncertainty(i, other.position_uncertainty)
                          : other.age > 0.0 ? position_uncertainty(fastest(arm.limits.acceleration), other.age)
                                            : 0.0;
    reach_of_arm_[i] =
        other.plans ? reach_of(damper, margin, 0.0, 2.0) : reach_of(damper, margin, fastest(other.qd.cwiseAbs()), 1.0);
  }
}

/// Computes how far each body may be from its nominal position, and returns the largest distance [m]. Turning the
/// joints one by one, from the tip to the base, moves a body's points by at most lever times angle each.
double LocalScene::update_body_uncertainty(int arm, const JointVector& position_uncertainty) {
  double farthest = 0.0;
  for (std::size_t body = 0; body < body_uncertainty_[arm].size(); ++body) {
    body_uncertainty_[arm][body] = levers_[arm][body].dot(position_uncertainty);
    farthest = std::max(farthest, body_uncertainty_[arm][body]);
  }
  return farthest;
}

/// True if the arm can be within reach in any configuration. Needs no kinematics, so that the cost of a tick depends on
/// the neighbours and not on the size of the cell.
bool LocalScene::may_matter(const CellGeometry& geometry, const LocalParameters& parameters, int arm,
                            const ArmObservation& other, double dt) const {
  const world::BoundingSphere& reach = geometry.arm_reach(arm);
  const Damper damper = parameters.damper.against_others(stop_times_[arm] + dt);
  const double margin = other.lost() ? other.position_uncertainty.sum() * lever_[arm]
                                     : position_uncertainty(acceleration_[arm], other.age);
  const Reach farthest = other.plans ? reach_of(damper, margin, 0.0, 2.0)
                                     : reach_of(damper, margin, other.qd.lpNorm<1>() * lever_[arm], 1.0);
  const double influence = InfluenceDistances::distance(farthest, own_fastest_);
  if (gap_to_arm_[arm] > influence) return false;
  const double distance = influence + reach.radius;
  const std::vector<CarriedBall>& own = balls_of_arm_[geometry.self()];
  return std::any_of(own.begin(), own.end(), [&](const CarriedBall& ball) {
    const double sum = distance + ball.radius;
    return !((Eigen::Map<const Eigen::Vector3d>(ball.centre_W) - reach.centre).squaredNorm() > sum * sum);
  });
}

/// The same for all arms at once: arms with a larger gap [m] cannot matter, for any state within the age limit.
double LocalScene::farthest_influence(const LocalParameters& parameters, double dt) const {
  const Damper damper = parameters.damper.against_others(longest_stop_ + dt);
  const double margin = position_uncertainty(strongest_other_, parameters.state_age_limit);
  return InfluenceDistances::distance(reach_of(damper, margin, fastest_other_, 2.0), own_fastest_);
}

void LocalScene::update_obstacles(const CellGeometry& geometry, const LocalParameters& parameters,
                                  const TickInput& input) {
  const auto count = static_cast<std::size_t>(geometry.obstacle_count());
  obstacles_now_ = input.obstacles.first(count);
  const auto is_old = [](const world::ObstacleState& state) { return state.age > 0.0; };
  if (std::any_of(obstacles_now_.begin(), obstacles_now_.end(), is_old)) {
    std::transform(obstacles_now_.begin(), obstacles_now_.end(), extrapolated_.begin(),
                   [](const world::ObstacleState& then) { return extrapolated(then); });
    obstacles_now_ = extrapolated_;
  }
  obstacle_reaches_ = all_alike(obstacles_now_) ? std::min<std::size_t>(count, 1) : count;
  const Damper damper = parameters.damper.against_others(stop_times_[geometry.self()] + input.dt);
  for (std::size_t i = 0; i < obstacle_reaches_; ++i) {
    const world::ObstacleState& state = obstacles_now_[i];
    reach_of_obstacle_[i] = reach_of(damper, position_uncertainty(parameters.acceleration_of_obstacles, state.age),
                                     fastest_point(radius_of_obstacle_[i], state.velocity), 1.0);
  }
}

}  // namespace hecaton::planner
