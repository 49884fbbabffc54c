#pragma once
/// Constraints on the next joint velocity: linear rows from clearances, and bounds from the joint limits.

#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// A linear constraint g · q̇ ≤ h from the clearance of one pair of bodies.
struct Row {
  JointVector g;            ///< approach speed per joint rate [m/rad | m/m]
  double h = 0.0;           ///< allowed approach speed [m/s]; negative: a retreat
  std::uint32_t key = 0;    ///< identifies the pair of bodies from tick to tick
  bool influences = false;  ///< the pair is nearer than dᵢ: boundary following considers it
  int arm = -1;             ///< index of the arm that the other body belongs to; −1: no other arm
  int clearance = -1;       ///< index of the clearance
  double stop_time = 0.0;   ///< the damper can be kept while stops take no longer than this [s]
};

/// Bounds of a joint velocity.
struct VelocityBounds {
  JointVector lower;  ///< [rad/s | m/s]
  JointVector upper;  ///< [rad/s | m/s], ≥ lower
};

/// Velocity limits, reduced near position limits so that the stop profile always ends inside them. Outside a position
/// limit only the return is allowed. `dt`: control period [s].
[[nodiscard]] VelocityBounds speed_and_position_bounds(const JointLimits& limits, const JointVector& q, double dt);

/// The velocities that the acceleration limits allow one period after q̇. `braking`: next velocity of the stop profile;
/// it is always inside.
[[nodiscard]] VelocityBounds acceleration_bounds(const JointLimits& limits, const JointVector& qd,
                                                 const JointVector& braking, double dt);

/// The intersection, widened where needed so that `braking` stays inside: stopping is always allowed.
[[nodiscard]] VelocityBounds intersect(const VelocityBounds& a, const VelocityBounds& b, const JointVector& braking);

}  // namespace hecaton::planner
