#pragma once
/// Time parametrisation of a path: blends its corners where the blend is free, then moves as fast as the limits allow.

#include "planner/global/validity.hpp"
#include "planner/trajectory/jerk_limited.hpp"
#include "planner/trajectory/time_optimal.hpp"

namespace hecaton::planner::global {

struct TimedPathOptions {
  BlendOptions blend = {};
  TimingOptions timing = {};
  double clearance = 0.0;  ///< distance that blends keep from the world, beyond the padding [m]
};

/// Velocity and acceleration limits of the planned arms, concatenated.
[[nodiscard]] MotionLimits motion_limits(const Validity& validity);

/// A trajectory from rest to rest along `path` [rad | m], whose edges must be free. All blends are proven free
/// (Validity::curve_free).
[[nodiscard]] Trajectory timed_path(const Validity& validity, const std::vector<std::vector<double>>& path,
                                    const TimedPathOptions& options = {});

/// The same, with the jerk of each joint limited to `jerk` > 0 [rad/s³ | m/s³] (planner/trajectory/jerk_limited.hpp).
/// What leaves the path is proven free.
[[nodiscard]] AveragedTrajectory jerk_limited_path(const Validity& validity,
                                                   const std::vector<std::vector<double>>& path, double jerk,
                                                   const TimedPathOptions& options = {});

}  // namespace hecaton::planner::global
