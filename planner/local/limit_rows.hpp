#pragma once
/// The joints' own limits as bounds on the next joint velocity.

#include "planner/model/limits.hpp"

namespace hecaton::planner {

struct VelocityBounds {
  JointVector lower;  ///< [rad/s | m/s]
  JointVector upper;  ///< [rad/s | m/s], ≥ lower
};

/// Velocity limits, tightened near position limits so that the stop profile always ends inside them, and so that one
/// period never crosses them. A reference outside its limits may only come back.
[[nodiscard]] VelocityBounds speed_and_position_bounds(const JointLimits& limits, const JointVector& q, double dt);

/// What the acceleration limits allow one period after q̇. `braking` (the stop profile's next velocity) is always
/// inside.
[[nodiscard]] VelocityBounds acceleration_bounds(const JointLimits& limits, const JointVector& qd,
                                                 const JointVector& braking, double dt);

/// The intersection, widened where needed so that `braking` stays inside: stopping is always allowed.
[[nodiscard]] VelocityBounds intersect(const VelocityBounds& a, const VelocityBounds& b, const JointVector& braking);

}  // namespace hecaton::planner
