#pragma once
/// A path with times that limit jerk, too: the fastest within velocity and acceleration limits, averaged over time
/// (averaged_trajectory.hpp). Averaging cuts corners. Where what it leads through is not free, or too far from the
/// path, the corners concerned are rounded more tightly, and at last the arm stops there for as long as the window is:
/// then it is on the path all the time, so that there is always an answer.

#include <functional>
#include <vector>

#include "planner/trajectory/averaged_trajectory.hpp"

namespace hecaton::planner {

/// Whether everything within `spread` of the straight way, joint by joint, is free.
using SegmentFree =
    std::function<bool(const Eigen::VectorXd& from, const Eigen::VectorXd& to, const Eigen::VectorXd& spread)>;

struct JerkOptions {
  double jerk = 100.0;      ///< of each joint no more [rad/s³ | m/s³], > 0
  BlendOptions blend = {};  ///< its deviation holds for what is averaged, too (looked at at every chord's ends)
  TimingOptions timing = {};
};

/// From rest to rest along the waypoints, whose straight ways must be free, within the limits. Where it leaves them it
/// is asked for chord by chord. The window is as long as the largest acceleration needs, and gentler accelerations need
/// shorter ones: of all joints' acceleration limits the share is taken that gets there first.
[[nodiscard]] AveragedTrajectory jerk_limited(const std::vector<Eigen::VectorXd>& waypoints,
                                              const CurveFree& curve_free, const SegmentFree& segment_free,
                                              const MotionLimits& limits, const JerkOptions& options);

}  // namespace hecaton::planner
