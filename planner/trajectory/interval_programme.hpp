#pragma once
/// What acceleration limits allow between two points of a grid on a path: a linear programme in x = ṡ² at either point.

#include <Eigen/Core>

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

}  // namespace hecaton::planner
