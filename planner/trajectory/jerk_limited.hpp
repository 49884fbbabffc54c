#pragma once
/// A timed path that limits velocity, acceleration and jerk.

#include <functional>
#include <vector>

#include "planner/trajectory/time_optimal.hpp"

namespace hecaton::planner {

class AveragedTrajectory {
 public:
  AveragedTrajectory() = default;
  /// `window`: T [s]; 0: as it was.
  explicit AveragedTrajectory(Trajectory trajectory, double window = 0.0);

  [[nodiscard]] bool empty() const { return of_.pieces().empty(); }           ///< leads nowhere
  [[nodiscard]] double window() const { return window_; }                     ///< [s]
  [[nodiscard]] double duration() const { return of_.duration() + window_; }  ///< [s]
  [[nodiscard]] const Trajectory& averaged() const { return of_; }
  /// At rest at its ends before 0 and after the duration. It must not be empty.
  [[nodiscard]] TrajectoryPoint at(double t) const;

 private:
  [[nodiscard]] Eigen::VectorXd integral(double t) const;
  [[nodiscard]] Eigen::VectorXd within(const Trajectory::Phase& phase, double dt) const;

  Trajectory of_;
  double window_ = 0.0;
  std::vector<Eigen::VectorXd> before_;  ///< ∫ (q − q(0)) until each phase begins, and until the end
};

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
