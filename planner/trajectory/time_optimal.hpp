#pragma once
/// The fastest way along a path that velocity and acceleration limits allow: time-optimal path parametrisation by
/// reachability [Pham18], with x = ṡ² and u = s̈ along q(s):
///     q̇ = q′ √x,   q̈ = q′ u + q″ x,   dx/ds = 2u.
/// A pass backwards finds for every point of a grid the largest x from which the end can be reached, a pass forwards
/// takes the largest x that stays below; each step is an exact linear programme in two variables.
///
/// differs from paper: u is constant between points of the grid and pieces are lines and parabolas (blended_path.hpp),
/// so that q̈ is linear in s there and asking at both ends of an interval holds the limits everywhere in it. Lines need
/// no grid: their limits do not change, and what is fastest on them is a trapezoid.

#include <vector>

#include <Eigen/Core>

#include "planner/trajectory/blended_path.hpp"

namespace hecaton::planner {

/// All |a x + b y| ≤ w, x ≥ 0, y ≥ 0 of one interval of width h: x at its beginning, y at its end, u = (y − x)/2h.
class IntervalProgramme {
 public:
  /// q′ at both ends, q″ in between, the joints' acceleration limits.
  IntervalProgramme(const Eigen::VectorXd& slope_begin, const Eigen::VectorXd& slope_end, const Eigen::VectorXd& bend,
                    double h, const Eigen::VectorXd& acceleration);

  /// The largest x ≤ most_x from which some y ≤ most_y can be reached.
  [[nodiscard]] double largest_begin(double most_x, double most_y) const;
  /// The largest y ≤ most_y that can be reached from x, which largest_begin does not exceed.
  [[nodiscard]] double largest_end(double x, double most_y) const;

 private:
  /// A bound of y by a line: y ≤ or ≥ value at x, with that slope.
  struct Bound {
    double value;
    double slope;
  };
  [[nodiscard]] Bound upper(double x, double most_y) const;
  [[nodiscard]] Bound lower(double x) const;

  Eigen::Matrix<double, Eigen::Dynamic, 3> strips_;  ///< a, b, w a row
};

/// One value a joint, as JointLimits has them, of one arm or of several one after the other.
struct MotionLimits {
  Eigen::VectorXd velocity;      ///< [rad/s | m/s], > 0
  Eigen::VectorXd acceleration;  ///< [rad/s² | m/s²], > 0
};

/// Where an arm is, and how it moves.
struct TrajectoryPoint {
  Eigen::VectorXd q;    ///< [rad | m]
  Eigen::VectorXd qd;   ///< [rad/s | m/s]
  Eigen::VectorXd qdd;  ///< [rad/s² | m/s²]
};

/// A path with times, from rest to rest.
class Trajectory {
 public:
  /// Constant s̈ on a part of a piece.
  struct Phase {
    int piece = 0;
    double s = 0.0;   ///< where it begins on the piece
    double sd = 0.0;  ///< ṡ there [1/s]
    double sdd = 0.0;
    double begins = 0.0;  ///< [s]
  };

  Trajectory() = default;
  Trajectory(std::vector<PathPiece> pieces, std::vector<Phase> phases, double duration)
      : pieces_(std::move(pieces)), phases_(std::move(phases)), duration_(duration) {}

  [[nodiscard]] double duration() const { return duration_; }  ///< [s]
  [[nodiscard]] const std::vector<PathPiece>& pieces() const { return pieces_; }
  [[nodiscard]] const std::vector<Phase>& phases() const { return phases_; }
  /// At rest at its ends before 0 and after the duration. There must be pieces.
  [[nodiscard]] TrajectoryPoint at(double t) const;

 private:
  std::vector<PathPiece> pieces_;
  std::vector<Phase> phases_;
  double duration_ = 0.0;
};

struct TimingOptions {
  int intervals = 24;  ///< of a blend's grid, > 0
};

/// From rest to rest within the limits, also between the points of the grid. No pieces: nothing, in no time.
[[nodiscard]] Trajectory time_optimal(std::vector<PathPiece> pieces, const MotionLimits& limits,
                                      const TimingOptions& options = {});

}  // namespace hecaton::planner
