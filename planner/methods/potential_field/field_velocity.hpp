#pragma once
/// Where a live arm goes in a potential field.

#include "planner/methods/potential_field/potential_field.hpp"
#include "planner/model/limits.hpp"

namespace hecaton::planner::potential {

/// The joint velocity down the gradient [rad/s | m/s]: as fast as the limits allow, slower where repulsion all but
/// cancels attraction, and slowing down in time to stop at the goal. Near the goal straight to it: repulsion shifts the
/// minimum away from a goal near an obstacle.
/// differs from paper: a direction only; what the local planner makes of it keeps limits and distances
/// (docs/potential-fields.md).
[[nodiscard]] JointVector field_velocity(const JointLimits& limits, const FieldValue& field, const JointVector& q,
                                         const JointVector& q_goal, double dt);

}  // namespace hecaton::planner::potential
