#include "planner/trajectory/interval_programme.hpp"

#include <gtest/gtest.h>

#include "planner/local/random.hpp"

namespace hecaton::planner {
namespace {

struct Interval {
  Eigen::VectorXd begin, end, bend, limit;
  double h;

  explicit Interval(Random& random) {
    const Eigen::Index n = 1 + static_cast<Eigen::Index>(random.next() % 7);
    const auto draw = [&](double low, double high) {
      return Eigen::VectorXd(Eigen::VectorXd::NullaryExpr(n, [&] { return random.uniform(low, high); }));
    };
    begin = draw(-1, 1);
    bend = draw(-5, 5);
    h = random.uniform(0.001, 0.1);
    end = begin + h * bend;
    limit = draw(0.5, 5);
  }
  /// q̈ = q′ u + q″ ṡ² at both ends, within the limits but for rounding.
  [[nodiscard]] bool allows(double x, double y, double factor) const {
    const double u = (y - x) / (2 * h);
    const Eigen::VectorXd first = begin * u + bend * x;
    const Eigen::VectorXd last = end * u + bend * y;
    return (first.cwiseAbs().array() <= factor * limit.array()).all() &&
           (last.cwiseAbs().array() <= factor * limit.array()).all();
  }
};

TEST(IntervalProgramme, FindsTheLargestThatAScanFinds) {
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    const Interval interval(random);
    const IntervalProgramme programme(interval.begin, interval.end, interval.bend, interval.h, interval.limit);
    const double most_x = random.uniform(0.1, 3), most_y = random.uniform(0.0, 3);
    const double x = programme.largest_begin(most_x, most_y);
    const double y = programme.largest_end(x, most_y);
    ASSERT_LE(x, most_x);
    ASSERT_LE(y, most_y);
    ASSERT_TRUE(interval.allows(x, y, 1 + 1e-9)) << i;
    constexpr int kScan = 200;
    for (int a = 0; a <= kScan; ++a) {
      for (int b = 0; b <= kScan; ++b) {
        const double scan_x = most_x * a / kScan, scan_y = most_y * b / kScan;
        if (interval.allows(scan_x, scan_y, 1 - 1e-9)) {
          ASSERT_LE(scan_x, x + 1e-9) << i;
        }
        if (a == 0 && interval.allows(x, scan_y, 1 - 1e-9)) {
          ASSERT_LE(scan_y, y + 1e-9) << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace hecaton::planner
