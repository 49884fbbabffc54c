#pragma once
/// Where the arm would go if nothing were in its way.

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// q_to − q_from; continuous joints (infinite limits) take the short way round.
[[nodiscard]] JointVector joint_difference(const JointLimits& limits, const JointVector& q_from,
                                           const JointVector& q_to);

/// The joint velocity of the straight line to the goal, as fast as the limits allow and slowing down in time to stop
/// there [rad/s | m/s].
[[nodiscard]] JointVector goal_velocity(const JointLimits& limits, const JointVector& q, const JointVector& q_goal,
                                        double dt);

/// How far ahead on the line along the unit vector `direction` a goal must be for goal_velocity to be `speed` long, as
/// far as the joints' velocity limits let it [rad | m].
[[nodiscard]] double approach_distance(const JointLimits& limits, const JointVector& direction, double speed,
                                       double dt);

}  // namespace hecaton::planner
