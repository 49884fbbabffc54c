#pragma once
/// Time-optimal path parametrisation under velocity and acceleration limits by reachability analysis [Pham18], with
/// x = ṡ² and u = s̈ along q(s):
///     q̇ = q′ √x,   q̈ = q′ u + q″ x,   dx/ds = 2u.
/// The backward pass finds the largest x at each grid point from which the end is reachable. The forward pass takes the
/// largest x below that. Each step solves a linear programme in two variables exactly.
///
/// differs from paper: u is constant between grid points, and pieces are lines and parabolas (blended_path.hpp). Then q̈
/// is linear in s, and the limits hold in a whole interval if they hold at its ends. Lines need no grid: their optimal
/// profile is a trapezoid.

#include <vector>

#include <Eigen/Core>

#include "planner/trajectory/blended_path.hpp"

namespace hecaton::planner {

/// The linear programme of one grid interval of width h: |a x + b y| ≤ w for every joint, x ≥ 0 at its beginning, y ≥ 0
/// at its end, u = (y − x)/2h.
class IntervalProgramme {
 public:
  /// q′ at both ends, q″ (`bend`), the interval's width, and the acceleration limits.
  IntervalProgramme(const Eigen::VectorXd& slope_begin, const Eigen::VectorXd& slope_end, const Eigen::VectorXd& bend,
                    double h, const Eigen::VectorXd& acceleration);

  /// The largest x ≤ most_x from which some y ≤ most_y is reachable.
  [[nodiscard]] double largest_begin(double most_x, double most_y) const;
  /// The largest y ≤ most_y that is reachable from x. Precondition: x ≤ largest_begin().
  [[nodiscard]] double largest_end(double x, double most_y) const;

 private:
  /// A bound of y at x, and its slope.
  struct Bound {
    double value;
    double slope;
  };
  [[nodiscard]] Bound upper(double x, double most_y) const;
  [[nodiscard]] Bound lower(double x) const;

  Eigen::Matrix<double, Eigen::Dynamic, 3> strips_;  ///< rows of a, b, w
};

/// Limits of all joints of one arm, or of several arms in sequence.
struct MotionLimits {
  Eigen::VectorXd velocity;      ///< [rad/s | m/s], > 0
  Eigen::VectorXd acceleration;  ///< [rad/s² | m/s²], > 0
};

/// State on a trajectory.
struct TrajectoryPoint {
  Eigen::VectorXd q;    ///< [rad | m]
  Eigen::VectorXd qd;   ///< [rad/s | m/s]
  Eigen::VectorXd qdd;  ///< [rad/s² | m/s²]
};

/// A timed path from rest to rest. Immutable.
class Trajectory {
 public:
  /// A part of a piece with constant s̈.
  struct Phase {
    int piece = 0;
    double s = 0.0;       ///< path parameter at the start of the phase
    double sd = 0.0;      ///< ṡ at the start [1/s]
    double sdd = 0.0;     ///< s̈ [1/s²]
    double begins = 0.0;  ///< [s]
  };

  Trajectory() = default;
  Trajectory(std::vector<PathPiece> pieces, std::vector<Phase> phases, double duration)
      : pieces_(std::move(pieces)), phases_(std::move(phases)), duration_(duration) {}

  [[nodiscard]] double duration() const { return duration_; }  ///< [s]
  [[nodiscard]] const std::vector<PathPiece>& pieces() const { return pieces_; }
  [[nodiscard]] const std::vector<Phase>& phases() const { return phases_; }
  /// State at time t [s]; at rest at the ends before 0 and after duration(). Precondition: pieces() is not empty.
  [[nodiscard]] TrajectoryPoint at(double t) const;

 private:
  std::vector<PathPiece> pieces_;
  std::vector<Phase> phases_;
  double duration_ = 0.0;
};

struct TimingOptions {
  int intervals = 24;  ///< grid intervals of a blend, > 0
};

/// The fastest trajectory along `pieces` from rest to rest. The limits also hold between grid points. Without pieces
/// the trajectory is empty, of duration 0.
[[nodiscard]] Trajectory time_optimal(std::vector<PathPiece> pieces, const MotionLimits& limits,
                                      const TimingOptions& options = {});

}  // namespace hecaton::planner
