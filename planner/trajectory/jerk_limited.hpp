#pragma once
/// Trajectories within velocity, acceleration and jerk limits.

#include <functional>
#include <vector>

#include "planner/trajectory/time_optimal.hpp"

namespace hecaton::planner {

/// A trajectory averaged over a moving time window T, which limits its jerk:
///     q_f(t) = 1/T ∫ q over t−T … t.
/// Velocity and acceleration limits still hold, because both become means. The jerk (q̈(t) − q̈(t−T))/T is at most
/// 2 max|q̈|/T. The duration grows by T; the end points stay, at rest. While the window covers one straight line, the
/// result stays on that line. Elsewhere it deviates by at most max|q̈| T²/24 in each joint. Immutable.
class AveragedTrajectory {
 public:
  AveragedTrajectory() = default;
  /// `window`: T [s]; 0: no averaging.
  explicit AveragedTrajectory(Trajectory trajectory, double window = 0.0);

  [[nodiscard]] bool empty() const { return of_.pieces().empty(); }
  [[nodiscard]] double window() const { return window_; }                     ///< [s]
  [[nodiscard]] double duration() const { return of_.duration() + window_; }  ///< [s]
  [[nodiscard]] const Trajectory& averaged() const { return of_; }
  /// State at time t [s]; at rest at the ends before 0 and after duration(). Precondition: not empty().
  [[nodiscard]] TrajectoryPoint at(double t) const;

 private:
  [[nodiscard]] Eigen::VectorXd integral(double t) const;
  [[nodiscard]] Eigen::VectorXd within(const Trajectory::Phase& phase, double dt) const;

  Trajectory of_;
  double window_ = 0.0;
  std::vector<Eigen::VectorXd> before_;  ///< ∫ (q − q(0)) up to the start of each phase, and to the end
};

/// True if everything within `spread` (per joint) of the straight line is free of collisions.
using SegmentFree =
    std::function<bool(const Eigen::VectorXd& from, const Eigen::VectorXd& to, const Eigen::VectorXd& spread)>;

struct JerkOptions {
  double jerk = 100.0;      ///< limit of each joint [rad/s³ | m/s³], > 0
  BlendOptions blend = {};  ///< the deviation limit holds after averaging, too, and is checked at the ends of chords
  TimingOptions timing = {};
};

/// A trajectory from rest to rest along `waypoints`. Precondition: the straight lines between them are free. Averaging
/// cuts corners: `segment_free` checks each chord that leaves the lines. Where a chord is not free or deviates too far,
/// blends shrink, and finally the arm stops at the corner, so that there is always a result. The window follows from
/// the largest acceleration. The function tries reduced acceleration limits, which need shorter windows, and keeps the
/// fastest result.
[[nodiscard]] AveragedTrajectory jerk_limited(const std::vector<Eigen::VectorXd>& waypoints,
                                              const CurveFree& curve_free, const SegmentFree& segment_free,
                                              const MotionLimits& limits, const JerkOptions& options);

}  // namespace hecaton::planner
