#pragma once
/// A found path as a trajectory: corners rounded where that stays free, then as fast as the arms' limits allow.

#include "planner/global/validity.hpp"
#include "planner/trajectory/jerk_limited.hpp"
#include "planner/trajectory/time_optimal.hpp"

namespace hecaton::planner::global {

struct TimedPathOptions {
  BlendOptions blend = {};
  TimingOptions timing = {};
  double clearance = 0.0;  ///< that blends keep from the world beyond the validity's padding [m]
};

/// The planned arms' velocity and acceleration limits, one arm after the other.
[[nodiscard]] MotionLimits motion_limits(const Validity& validity);

/// Rest to rest along the path, whose straight ways must be free. Every blend is proven to be (Validity::proven_free).
[[nodiscard]] Trajectory timed_path(const Validity& validity, const std::vector<std::vector<double>>& path,
                                    const TimedPathOptions& options = {});

/// The same with no joint's jerk above `jerk` [rad/s³ | m/s³], > 0 (planner/trajectory/jerk_limited.hpp): whatever is
/// not on the path itself is proven free.
[[nodiscard]] AveragedTrajectory jerk_limited_path(const Validity& validity,
                                                   const std::vector<std::vector<double>>& path, double jerk,
                                                   const TimedPathOptions& options = {});

}  // namespace hecaton::planner::global
