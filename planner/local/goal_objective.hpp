#pragma once
/// The joint velocity towards a goal before any constraint acts [Lahouar06, section 2], and the deadlock rule.

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// q_to − q_from [rad | m]. Continuous joints (infinite limits) take the shorter direction.
[[nodiscard]] JointVector joint_difference(const JointLimits& limits, const JointVector& q_from,
                                           const JointVector& q_to);

/// The joint velocity on the straight line to the goal [rad/s | m/s]. It is as large as the limits allow, and small
/// enough to stop at the goal. `dt`: control period [s].
[[nodiscard]] JointVector goal_velocity(const JointLimits& limits, const JointVector& q, const JointVector& q_goal,
                                        double dt);

/// The distance of a goal along the unit vector `direction` at which goal_velocity() has the norm `speed` [rad | m].
/// Inverse of goal_velocity() below the velocity limits.
[[nodiscard]] double approach_distance(const JointLimits& limits, const JointVector& direction, double speed,
                                       double dt);

/// The deadlock rule of [Lahouar06, section 4]: ‖intended‖ is below `fraction` of ‖wanted‖.
/// differs from paper: compares with min(‖q_goal − q‖, Δq_max) instead of Δq_max, to avoid deadlocks near every goal.
/// It uses the intended velocity before acceleration limits, to avoid deadlocks at every start.
[[nodiscard]] inline bool deadlocked(const JointVector& intended, const JointVector& wanted, double fraction) {
  return intended.norm() < fraction * wanted.norm();
}

}  // namespace hecaton::planner
