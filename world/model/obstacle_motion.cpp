#include "world/model/obstacle_motion.hpp"

#include <cmath>
#include <numbers>

namespace hecaton::world {
namespace {

/// A relative change of velocity below this is no corner.
constexpr double kStraightOn = 1e-6;

/// Remainder of time / period in [0, period).
double wrap(double time, double period) {
  const double rest = std::fmod(time, period);
  return rest < 0.0 ? rest + period : rest;
}

/// On the straight line from one waypoint to another, `travelled` [m] after leaving the first.
MotionState on_line(const Pose& from, const Pose& to, double travelled, double length, double speed) {
  const double share = travelled / length;
  MotionState state;
  const Eigen::Vector3d line = to.translation() - from.translation();
  state.X_WO.translation() = from.translation() + share * line;
  state.velocity.linear = line * (speed / length);

  // Slerp: a constant rate about one axis, which the rotation itself leaves in place.
  const Eigen::Quaterniond from_to(from.linear().transpose() * to.linear());
  const Eigen::AngleAxisd turn(from_to.w() < 0.0 ? Eigen::Quaterniond(-from_to.coeffs()) : from_to);
  state.X_WO.linear() = from.linear() * Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
  state.velocity.angular = from.linear() * turn.axis() * (turn.angle() * speed / length);
  return state;
}

/// The straight lines of one round: 0 → 1 → … → 0, or 0 → 1 → … → n−1 → … → 0.
struct Line {
  std::size_t from;
  std::size_t to;
};
std::size_t line_count(const WaypointMotion& motion) {
  return motion.loop ? motion.poses_W.size() : 2 * (motion.poses_W.size() - 1);
}
Line line_at(const WaypointMotion& motion, std::size_t i) {
  const std::size_t count = motion.poses_W.size();
  if (motion.loop) return {i, (i + 1) % count};
  return i + 1 < count ? Line{i, i + 1} : Line{line_count(motion) - i, line_count(motion) - i - 1};
}

double length_of(const WaypointMotion& motion, const Line& line) {
  return (motion.poses_W[line.to].translation() - motion.poses_W[line.from].translation()).norm();
}

/// [m/s]; zero between waypoints that differ in orientation only, because no time passes between them.
Eigen::Vector3d velocity_on(const WaypointMotion& motion, const Line& line) {
  const Eigen::Vector3d way = motion.poses_W[line.to].translation() - motion.poses_W[line.from].translation();
  return way.norm() > 0.0 ? Eigen::Vector3d(motion.speed * way.normalized()) : Eigen::Vector3d::Zero();
}

/// Of one round [m].
double round_length(const WaypointMotion& motion) {
  double round = 0.0;
  for (std::size_t i = 0; i < line_count(motion); ++i) round += length_of(motion, line_at(motion, i));
  return round;
}

MotionState at(const WaypointMotion& motion, double time) {
  const std::size_t lines = line_count(motion);
  const double round = round_length(motion);
  if (lines == 0 || round <= 0.0) return {motion.poses_W.front(), {}};

  double left = wrap(motion.speed * time, round);
  for (std::size_t i = 0;; i = (i + 1) % lines) {
    const Line line = line_at(motion, i);
    const double length = length_of(motion, line);
    if (left < length) {
      return on_line(motion.poses_W[line.from], motion.poses_W[line.to], left, length, motion.speed);
    }
    // Rounding can leave a remainder at the end of the round: the next round begins.
    left = i + 1 == lines ? 0.0 : left - length;
  }
}

MotionState at(const CircleMotion& motion, const Pose& X_WO, double time) {
  const Eigen::AngleAxisd turn(motion.angular_speed * time, motion.axis_W);
  const Eigen::Vector3d spoke = turn * (X_WO.translation() - motion.centre_W);
  const Eigen::Vector3d rate = motion.angular_speed * motion.axis_W;
  MotionState state{X_WO, {}};
  state.X_WO.translation() = motion.centre_W + spoke;
  state.velocity.linear = rate.cross(spoke);
  if (motion.turn_with_motion) {
    state.X_WO.linear() = turn.toRotationMatrix() * X_WO.linear();
    state.velocity.angular = rate;
  }
  return state;
}

MotionState at(const SineMotion& motion, const Pose& X_WO, double time) {
  const double rate = 2.0 * std::numbers::pi / motion.period;
  const double angle = rate * time + motion.phase;
  MotionState state{X_WO, {}};
  state.X_WO.translation() += motion.direction_W * (motion.amplitude * std::sin(angle));
  state.velocity.linear = motion.direction_W * (motion.amplitude * rate * std::cos(angle));
  return state;
}

MotionState at(const ConveyorMotion& motion, const Pose& X_WO, double time) {
  const double travelled = std::copysign(wrap(std::abs(motion.speed) * time, motion.length), motion.speed);
  MotionState state{X_WO, {}};
  state.X_WO.translation() += motion.direction_W * travelled;
  state.velocity.linear = motion.direction_W * motion.speed;
  return state;
}

/// Time for a way of this length at this speed [s]; 0 without way or speed.
double time_for(double length, double speed) {
  return length > 0.0 && speed != 0.0 ? length / std::abs(speed) : 0.0;
}

double acceleration_of(const CircleMotion& motion, const Pose& X_WO) {
  const Eigen::Vector3d spoke = X_WO.translation() - motion.centre_W;
  return motion.angular_speed * motion.angular_speed * motion.axis_W.cross(spoke).norm();
}

double acceleration_of(const SineMotion& motion) {
  const double rate = 2.0 * std::numbers::pi / motion.period;
  return std::abs(motion.amplitude) * rate * rate;
}

}  // namespace

std::vector<ScriptBreak> script_breaks(const Obstacle& obstacle) {
  std::vector<ScriptBreak> breaks;
  if (const auto* conveyor = std::get_if<ConveyorMotion>(&obstacle.motion)) {
    breaks.push_back({motion_at(obstacle, 0.0).X_WO, 0.0, conveyor->length});
  }
  if (const auto* motion = std::get_if<WaypointMotion>(&obstacle.motion)) {
    const std::size_t lines = round_length(*motion) > 0.0 ? line_count(*motion) : 0;
    for (std::size_t i = 0; i < lines; ++i) {
      const Line next = line_at(*motion, i);
      const Eigen::Vector3d change =
          velocity_on(*motion, next) - velocity_on(*motion, line_at(*motion, (i + lines - 1) % lines));
      if (change.norm() > kStraightOn * motion->speed) {
        breaks.push_back({motion->poses_W[next.from], change.norm(), 0.0});
      }
    }
  }
  return breaks;
}

bool is_scripted(const Motion& motion) {
  return !std::holds_alternative<StaticMotion>(motion) && !std::holds_alternative<DynamicMotion>(motion);
}

MotionState motion_at(const Obstacle& obstacle, double time) {
  struct Visitor {
    const Pose& X_WO;
    double time;
    MotionState operator()(const StaticMotion&) const { return {X_WO, {}}; }
    MotionState operator()(const WaypointMotion& motion) const { return at(motion, time); }
    MotionState operator()(const CircleMotion& motion) const { return at(motion, X_WO, time); }
    MotionState operator()(const SineMotion& motion) const { return at(motion, X_WO, time); }
    MotionState operator()(const ConveyorMotion& motion) const { return at(motion, X_WO, time); }
    MotionState operator()(const DynamicMotion& motion) const { return {X_WO, motion.initial_velocity}; }
  };
  return std::visit(Visitor{obstacle.X_WO, time}, obstacle.motion);
}

double script_period(const Obstacle& obstacle) {
  struct Visitor {
    double operator()(const StaticMotion&) const { return 0.0; }
    double operator()(const DynamicMotion&) const { return 0.0; }
    double operator()(const WaypointMotion& motion) const { return time_for(round_length(motion), motion.speed); }
    double operator()(const CircleMotion& motion) const {
      return time_for(2.0 * std::numbers::pi, motion.angular_speed);
    }
    double operator()(const SineMotion& motion) const { return motion.amplitude == 0.0 ? 0.0 : motion.period; }
    double operator()(const ConveyorMotion& motion) const { return time_for(motion.length, motion.speed); }
  };
  return std::visit(Visitor{}, obstacle.motion);
}

double greatest_acceleration(const Obstacle& obstacle) {
  if (const auto* circle = std::get_if<CircleMotion>(&obstacle.motion)) return acceleration_of(*circle, obstacle.X_WO);
  if (const auto* sine = std::get_if<SineMotion>(&obstacle.motion)) return acceleration_of(*sine);
  return 0.0;
}

}  // namespace hecaton::world
