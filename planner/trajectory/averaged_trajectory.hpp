#pragma once
/// A trajectory averaged over a time window that moves along with it: what limits its jerk.
///
/// q_f(t) = 1/T ∫ q over t−T … t. Velocities and accelerations are means of what they were, so that their limits hold
/// still, and the jerk (q̈(t) − q̈(t−T))/T is at most 2 max|q̈|/T. It takes T longer, begins and ends where the other one
/// does, and at rest. As long as the window sees a straight part alone, it stays on that; elsewhere it is inside what
/// it saw by at most max|q̈| T²/24, joint by joint.

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

}  // namespace hecaton::planner
