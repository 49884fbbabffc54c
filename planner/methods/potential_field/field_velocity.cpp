#include "planner/methods/potential_field/field_velocity.hpp"

#include <algorithm>

#include "planner/local/goal_objective.hpp"

namespace hecaton::planner::potential {
namespace {

/// This near to the goal the arm goes straight there [rad | m].
constexpr double kHome = 0.1;
/// A total gradient below this share of the attraction's slows the arm down, in proportion.
constexpr double kCalm = 0.5;

}  // namespace

JointVector field_velocity(const JointLimits& limits, const FieldValue& field, const JointVector& q,
                           const JointVector& q_goal, double dt) {
  const double distance = joint_difference(limits, q, q_goal).norm();
  const double slope = field.gradient.norm();
  if (distance < kHome) return goal_velocity(limits, q, q_goal, dt);
  const JointVector down = steepest_descent(field);
  const double length = down.norm();
  if (length <= 0.0) return JointVector::Zero(q.size());
  const double calm = std::min(1.0, slope / (kCalm * field.attraction_gradient.norm() + 1e-12));
  const JointVector ahead = q + distance / length * down;
  return calm * goal_velocity(limits, q, ahead, dt);
}

}  // namespace hecaton::planner::potential
