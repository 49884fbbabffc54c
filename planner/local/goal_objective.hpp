#pragma once
/// The joint velocity towards the goal, before any constraint acts, and how little of it counts as a deadlock.

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

/// [Lahouar06] section 4: ‖Δq‖ below a share (30 %) of the step that the goal alone would ask for.
/// differs from paper: compared with min(‖q_goal − q‖, Δq_max) instead of Δq_max, or it would fire near every goal; and
/// it looks at what the local planner intends before acceleration limits, or it would fire at every start.
[[nodiscard]] inline bool deadlocked(const JointVector& intended, const JointVector& wanted, double fraction) {
  return intended.norm() < fraction * wanted.norm();
}

}  // namespace hecaton::planner
