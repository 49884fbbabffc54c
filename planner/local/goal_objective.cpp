#include "planner/local/goal_objective.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hecaton::planner {
namespace {

/// Share of the acceleration limit for the approach to a goal; the rest corrects deviations.
constexpr double kBrakingShare = 0.8;
/// The last part of the approach covers this share of the remaining distance each period.
constexpr double kFinalShare = 0.2;
/// Smaller components of a unit vector count as zero.
constexpr double kNoShare = 1e-12;

/// Speed from which `acceleration` stops within `distance`: √(2ad). Near the end it is gain · distance instead, because
/// the slope of the square root exceeds what one period can follow.
double approach_speed(double distance, double acceleration, double gain) {
  const double linear_until = acceleration / (gain * gain);
  return distance <= linear_until ? gain * distance : std::sqrt(2.0 * acceleration * (distance - 0.5 * linear_until));
}

}  // namespace

JointVector joint_difference(const JointLimits& limits, const JointVector& q_from, const JointVector& q_to) {
  JointVector difference = q_to - q_from;
  for (Eigen::Index j = 0; j < difference.size(); ++j) {
    if (std::isinf(limits.upper[j])) difference[j] = std::remainder(difference[j], 2.0 * std::numbers::pi);
  }
  return difference;
}

double approach_distance(const JointLimits& limits, const JointVector& direction, double speed, double dt) {
  double acceleration = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < direction.size(); ++j) {
    const double share = std::abs(direction[j]);
    if (share >= kNoShare) acceleration = std::min(acceleration, kBrakingShare * limits.acceleration[j] / share);
  }
  const double gain = kFinalShare / dt;
  const double linear_until = acceleration / (gain * gain);
  return speed <= gain * linear_until ? speed / gain : speed * speed / (2.0 * acceleration) + 0.5 * linear_until;
}

// [Lahouar06] eq. 1–2:  Δq_goal = (q_goal − q)/‖q_goal − q‖ · Δq_max, or q_goal − q when that is shorter.
// differs from paper: a velocity instead of a step. Δq_max is the longest step on this line within all velocity limits.
// The step shrinks before the goal, because the arm cannot stop within one period.
JointVector goal_velocity(const JointLimits& limits, const JointVector& q, const JointVector& q_goal, double dt) {
  const JointVector way = joint_difference(limits, q, q_goal);
  const double length = way.norm();
  if (length < 1e-12) return JointVector::Zero(q.size());
  const JointVector direction = way / length;
  double speed = std::numeric_limits<double>::infinity();
  double acceleration = speed;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double share = std::abs(direction[j]);
    if (share < kNoShare) continue;
    speed = std::min(speed, limits.velocity[j] / share);
    acceleration = std::min(acceleration, limits.acceleration[j] / share);
  }
  return direction * std::min(speed, approach_speed(length, kBrakingShare * acceleration, kFinalShare / dt));
}

}  // namespace hecaton::planner
