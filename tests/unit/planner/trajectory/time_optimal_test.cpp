#include "planner/trajectory/time_optimal.hpp"

#include <cmath>
#include <limits>

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

TEST(IntervalProgramme, MatchesAScan) {
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
namespace {

using Waypoints = std::vector<Eigen::VectorXd>;

bool always(const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&) {
  return true;
}
bool never(const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&) {
  return false;
}

Eigen::VectorXd draw(Random& random, Eigen::Index n, double low, double high) {
  return Eigen::VectorXd::NullaryExpr(n, [&] { return random.uniform(low, high); });
}

struct Case {
  Waypoints waypoints;
  MotionLimits limits;

  explicit Case(std::uint64_t seed) {
    Random random(seed);
    const auto n = static_cast<Eigen::Index>(2 + random.next() % 11);
    const std::uint64_t corners = random.next() % 8;
    for (std::uint64_t i = 0; i < 2 + corners; ++i) waypoints.push_back(draw(random, n, -2.0, 2.0));
    limits = {draw(random, n, 0.3, 3.0), draw(random, n, 0.5, 10.0)};
  }
};

double distance_to(const Waypoints& line, const Eigen::VectorXd& q) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Eigen::VectorXd way = line[i + 1] - line[i];
    const double t = std::clamp(way.dot(q - line[i]) / way.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (q - line[i] - t * way).norm());
  }
  return least;
}

/// Straight from a to b and at rest at both: accelerating all the way to the middle, or to the velocity limit. All
/// joints share the line's parameter, so that the tightest of them counts.
double trapezoid(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const MotionLimits& limits) {
  const double length = (b - a).norm();
  const Eigen::ArrayXd u = ((b - a) / length).cwiseAbs().array();
  const double v = (limits.velocity.array() / u).minCoeff();
  const double acceleration = (limits.acceleration.array() / u).minCoeff();
  return length > v * v / acceleration ? length / v + v / acceleration : 2.0 * std::sqrt(length / acceleration);
}

double rest_to_rest(const Case& tried) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < tried.waypoints.size(); ++i) {
    sum += trapezoid(tried.waypoints[i], tried.waypoints[i + 1], tried.limits);
  }
  return sum;
}

TEST(TimeOptimal, HoldsTheLimitsEverywhere) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Case tried(seed);
    const Trajectory trajectory = time_optimal(blended(tried.waypoints, always), tried.limits);
    // Ten times as many samples as phases, and in each phase some: short ones count, too.
    for (std::size_t i = 0; i < trajectory.phases().size(); ++i) {
      const double begins = trajectory.phases()[i].begins;
      const double ends =
          i + 1 < trajectory.phases().size() ? trajectory.phases()[i + 1].begins : trajectory.duration();
      for (int k = 0; k <= 10; ++k) {
        const TrajectoryPoint at = trajectory.at(begins + (ends - begins) * k / 10);
        ASSERT_TRUE((at.qd.cwiseAbs().array() <= tried.limits.velocity.array() * (1 + 1e-9)).all()) << "seed " << seed;
        ASSERT_TRUE((at.qdd.cwiseAbs().array() <= tried.limits.acceleration.array() * (1 + 1e-6)).all())
            << "seed " << seed << " phase " << i << ": " << at.qdd.transpose();
      }
    }
  }
}

TEST(TimeOptimal, VelocitiesMatchThePositions) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Case tried(seed);
    const Trajectory trajectory = time_optimal(blended(tried.waypoints, always), tried.limits);
    const double h = 1e-5;
    for (int k = 1; k < 500; ++k) {
      const double t = trajectory.duration() * k / 500;
      const Eigen::VectorXd qd = (trajectory.at(t + h).q - trajectory.at(t - h).q) / (2 * h);
      // Accelerations jump by at most twice their limit in between: 2 h · 10.
      ASSERT_LT((qd - trajectory.at(t).qd).cwiseAbs().maxCoeff(), 2e-4) << "seed " << seed << " t " << t;
    }
  }
}

TEST(TimeOptimal, BeginsAndEndsAtRestAtTheEnds) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Case tried(seed);
    const Trajectory trajectory = time_optimal(blended(tried.waypoints, always), tried.limits);
    const double soon = 1e-9;
    EXPECT_LT(trajectory.at(soon).qd.norm(), 1e-6);
    EXPECT_LT(trajectory.at(trajectory.duration() - soon).qd.norm(), 1e-6);
    EXPECT_EQ(trajectory.at(0.0).q, tried.waypoints.front());
    EXPECT_LT((trajectory.at(trajectory.duration()).q - tried.waypoints.back()).norm(), 1e-9);
    EXPECT_LT((trajectory.at(trajectory.duration() - soon).q - tried.waypoints.back()).norm(), 1e-6);
  }
}

TEST(TimeOptimal, StaysWithinTheDeviation) {
  for (const double deviation : {0.2, 0.05, 0.001}) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      const Case tried(seed);
      const Trajectory trajectory =
          time_optimal(blended(tried.waypoints, always, {.deviation = deviation}), tried.limits);
      for (int k = 0; k <= 1000; ++k) {
        const Eigen::VectorXd q = trajectory.at(trajectory.duration() * k / 1000).q;
        ASSERT_LE(distance_to(tried.waypoints, q), deviation * (1 + 1e-9) + 1e-12) << "seed " << seed;
      }
    }
  }
}

TEST(TimeOptimal, IsNeverSlowerThanStoppingAtEveryCorner) {
  double sum = 0.0, stopping = 0.0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    const Case tried(seed);
    const double duration = time_optimal(blended(tried.waypoints, always), tried.limits).duration();
    ASSERT_LE(duration, rest_to_rest(tried) * (1 + 1e-9)) << "seed " << seed;
    sum += duration;
    stopping += rest_to_rest(tried);
  }
  EXPECT_LT(sum, 0.98 * stopping) << "blends gain nothing";
}

TEST(TimeOptimal, LineGetsATrapezoid) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Case tried(seed);
    tried.waypoints.resize(2);
    // Points on the line are no corners.
    tried.waypoints.insert(tried.waypoints.begin() + 1, 0.3 * tried.waypoints[0] + 0.7 * tried.waypoints[1]);
    tried.waypoints.insert(tried.waypoints.begin() + 1, tried.waypoints[0]);
    const double duration = time_optimal(blended(tried.waypoints, always), tried.limits).duration();
    const double exact = trapezoid(tried.waypoints.front(), tried.waypoints.back(), tried.limits);
    ASSERT_NEAR(duration, exact, 1e-6 * exact);
  }
  // One joint, 1 rad, 1 rad/s, 2 rad/s²: ½ s to speed up over ¼ rad, the same to brake, ½ rad at 1 rad/s.
  const Waypoints one{Eigen::VectorXd::Constant(1, 0.0), Eigen::VectorXd::Constant(1, 1.0)};
  const MotionLimits limits{Eigen::VectorXd::Constant(1, 1.0), Eigen::VectorXd::Constant(1, 2.0)};
  EXPECT_NEAR(time_optimal(blended(one, always), limits).duration(), 1.5, 1e-9);
}

TEST(TimeOptimal, StopsWhereNoBlendIsFree) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Case tried(seed);
    const Trajectory trajectory = time_optimal(blended(tried.waypoints, never), tried.limits);
    EXPECT_NEAR(trajectory.duration(), rest_to_rest(tried), 1e-6 * rest_to_rest(tried));
    for (int k = 0; k <= 100; ++k) {
      EXPECT_LT(distance_to(tried.waypoints, trajectory.at(trajectory.duration() * k / 100).q), 1e-9);
    }
  }
}

TEST(TimeOptimal, BlendsShrinkUntilTheyAreFree) {
  const Waypoints corner{Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0), Eigen::Vector2d(1, 1)};
  double reach = 0.0;
  const auto small = [&](const Eigen::VectorXd& from, const Eigen::VectorXd& at, const Eigen::VectorXd& to) {
    EXPECT_NEAR((from - at).norm(), (to - at).norm(), 1e-12);
    reach = (from - at).norm();
    return reach < 0.02;
  };
  const auto pieces = blended(corner, small, {.deviation = 0.1});
  // 4 · 0.1/√2 = 0.283, halved four times: 0.0177.
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_NEAR(reach, 0.4 / std::sqrt(2.0) / 16.0, 1e-12);
  EXPECT_NEAR(pieces[1].length, 2.0 * reach, 1e-12);
}

/// What is fastest is at a limit all the time: were it nowhere, it could go faster.
TEST(TimeOptimal, AlwaysTouchesALimit) {
  int at_limit = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Case tried(seed);
    const Trajectory trajectory = time_optimal(blended(tried.waypoints, always), tried.limits, {.intervals = 200});
    for (int k = 0; k < 1000; ++k) {
      const TrajectoryPoint at = trajectory.at(trajectory.duration() * (k + 0.5) / 1000);
      const double load = std::max((at.qd.cwiseAbs().array() / tried.limits.velocity.array()).maxCoeff(),
                                   (at.qdd.cwiseAbs().array() / tried.limits.acceleration.array()).maxCoeff());
      at_limit += load > 0.97 ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GT(at_limit, 0.98 * all);
}

TEST(TimeOptimal, AFinerGridGainsLittle) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Case tried(seed);
    const double coarse = time_optimal(blended(tried.waypoints, always), tried.limits).duration();
    const double fine = time_optimal(blended(tried.waypoints, always), tried.limits, {.intervals = 500}).duration();
    EXPECT_NEAR(coarse, fine, 0.01 * fine) << "seed " << seed;
  }
}

TEST(TimeOptimal, EmptyPathTakesNoTime) {
  const MotionLimits limits{Eigen::VectorXd::Ones(2), Eigen::VectorXd::Ones(2)};
  const Waypoints still{Eigen::Vector2d(1, 2), Eigen::Vector2d(1, 2)};
  EXPECT_TRUE(blended(still, always).empty());
  EXPECT_EQ(time_optimal({}, limits).duration(), 0.0);
}

}  // namespace
}  // namespace hecaton::planner
