#pragma once
/// Constraints on the next joint velocity: a linear row, and the bounds that the joint limits set.

#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

struct Row {
  JointVector g;            ///< [m/rad | m/m]: approach speed per joint rate
  double h = 0.0;           ///< [m/s]
  std::uint32_t key = 0;    ///< names the pair of bodies from tick to tick
  bool influences = false;  ///< the pair is nearer than dᵢ: boundary following looks at it
  int arm = -1;             ///< index of the arm that the other body belongs to; −1: it is no other arm's
  int clearance = -1;       ///< index of the clearance it came from
  double stop_time = 0.0;   ///< the damper can be kept while stops take no longer than this [s]
};

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
