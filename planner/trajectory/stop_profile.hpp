#pragma once
/// The stop profile of an arm: all joints brake together in proportion to q̇, at the limit of the slowest joint. The
/// path of a stop is therefore the straight line q + s·q̇ in joint space, s from 0 to T/2. Pure functions; no
/// allocation.

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// Duration of the stop from q̇: T = maxⱼ |q̇ⱼ| / aⱼ [s].
[[nodiscard]] double stop_time(const JointLimits& limits, const JointVector& qd);

/// Duration of the longest stop that the limits allow [s].
[[nodiscard]] double longest_stop_time(const JointLimits& limits);

/// Velocity dt [s] after the start of the stop from q̇: q̇ · max(0, 1 − dt/T).
[[nodiscard]] JointVector braking_velocity(const JointLimits& limits, const JointVector& qd, double dt);

/// Advances (q, q̇) by t ≥ 0 [s] on the stop profile: q + q̇ (t − t²/2T) until rest.
void stop_for(const JointLimits& limits, double t, JointVector& q, JointVector& qd);

/// Rest position of the stop from (q, q̇): q + q̇ T/2.
[[nodiscard]] JointVector rest_position(const JointLimits& limits, const JointVector& q, const JointVector& qd);

}  // namespace hecaton::planner
