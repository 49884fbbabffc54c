#include "planner/trajectory/interval_programme.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner {

// q̈ at the beginning: q′ u + q″ x = (q″ − q′/2h) x + q′/2h y; at the end: −q′/2h x + (q″ + q′/2h) y.
IntervalProgramme::IntervalProgramme(const Eigen::VectorXd& slope_begin, const Eigen::VectorXd& slope_end,
                                     const Eigen::VectorXd& bend, double h, const Eigen::VectorXd& acceleration)
    : strips_(2 * bend.size(), 3) {
  const Eigen::Index n = bend.size();
  const Eigen::VectorXd begin = slope_begin / (2.0 * h);
  const Eigen::VectorXd end = slope_end / (2.0 * h);
  strips_.topRows(n) << bend - begin, begin, acceleration;
  strips_.bottomRows(n) << -end, bend + end, acceleration;
}

IntervalProgramme::Bound IntervalProgramme::upper(double x, double most_y) const {
  Bound least{most_y, 0.0};
  for (Eigen::Index i = 0; i < strips_.rows(); ++i) {
    const double a = strips_(i, 0), b = strips_(i, 1), w = strips_(i, 2);
    if (b == 0.0) continue;
    const double value = std::copysign(w / b, 1.0) - a / b * x;
    if (value < least.value) least = {value, -a / b};
  }
  return least;
}

IntervalProgramme::Bound IntervalProgramme::lower(double x) const {
  Bound most{0.0, 0.0};
  for (Eigen::Index i = 0; i < strips_.rows(); ++i) {
    const double a = strips_(i, 0), b = strips_(i, 1), w = strips_(i, 2);
    if (b == 0.0) continue;
    const double value = -std::copysign(w / b, 1.0) - a / b * x;
    if (value > most.value) most = {value, -a / b};
  }
  return most;
}

// lower − upper is convex in x and not above 0 at x = 0: Newton's steps from the right end at its largest root.
double IntervalProgramme::largest_begin(double most_x, double most_y) const {
  double x = most_x;
  for (Eigen::Index i = 0; i < strips_.rows(); ++i) {
    if (strips_(i, 1) == 0.0 && strips_(i, 0) != 0.0) x = std::min(x, strips_(i, 2) / std::abs(strips_(i, 0)));
  }
  for (int step = 0; step < 64; ++step) {
    const Bound low = lower(x);
    const Bound high = upper(x, most_y);
    const double excess = low.value - high.value;
    const double slope = low.slope - high.slope;
    if (excess <= 0.0 || slope <= 0.0) return x;
    const double next = std::max(0.0, x - excess / slope);
    if (next >= x) return x;
    x = next;
  }
  return 0.0;
}

double IntervalProgramme::largest_end(double x, double most_y) const {
  return std::max(0.0, upper(x, most_y).value);
}

}  // namespace hecaton::planner
