#pragma once
/// How an arm comes to rest: all joints together, along the direction in which they move, as hard as the first of them
/// can. The path of a stop is therefore known beforehand: the straight joint-space line q + s·q̇, s from 0 to T/2.

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// T = maxⱼ |q̇ⱼ| / aⱼ: how long the stop from q̇ takes [s].
[[nodiscard]] double stop_time(const JointLimits& limits, const JointVector& qd);

/// T of the fastest motion that the limits allow: no stop takes longer [s].
[[nodiscard]] double longest_stop_time(const JointLimits& limits);

/// The velocity dt [s] later when the stop from q̇ begins now: q̇ · max(0, 1 − dt/T).
[[nodiscard]] JointVector braking_velocity(const JointLimits& limits, const JointVector& qd, double dt);

/// Brings (q, q̇) to where it is t [s] later when the stop begins now: q + q̇ (t − t²/2T) until it is at rest, t ≥ 0.
void stop_for(const JointLimits& limits, double t, JointVector& q, JointVector& qd);

/// Where the arm comes to rest when the stop from (q, q̇) begins now: q + q̇ T/2.
[[nodiscard]] JointVector rest_position(const JointLimits& limits, const JointVector& q, const JointVector& qd);

}  // namespace hecaton::planner
