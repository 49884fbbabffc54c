#include "planner/trajectory/jerk_limited.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "planner/local/random.hpp"

namespace hecaton::planner {
namespace {

using Waypoints = std::vector<Eigen::VectorXd>;

bool curve_always(const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&) {
  return true;
}
bool segment_always_free(const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&) {
  return true;
}
bool segment_never_free(const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&) {
  return false;
}

struct Case {
  Waypoints waypoints;
  MotionLimits limits;
  double jerk;

  explicit Case(std::uint64_t seed) {
    Random random(seed);
    const auto n = static_cast<Eigen::Index>(2 + random.next() % 11);
    const auto draw = [&](double low, double high) {
      return Eigen::VectorXd(Eigen::VectorXd::NullaryExpr(n, [&] { return random.uniform(low, high); }));
    };
    const std::uint64_t corners = random.next() % 6;
    for (std::uint64_t i = 0; i < 2 + corners; ++i) waypoints.push_back(draw(-2.0, 2.0));
    limits = {draw(0.3, 3.0), draw(0.5, 10.0)};
    jerk = std::pow(10.0, random.uniform(0.5, 3.5));
  }
  [[nodiscard]] AveragedTrajectory trajectory(const SegmentFree& segment_free = segment_always_free) const {
    return jerk_limited(waypoints, curve_always, segment_free, limits, {.jerk = jerk});
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

/// Finite differences, of accelerations, of velocities, of positions: all three say the same.
TEST(JerkLimited, HoldsAllLimitsEverywhere) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Case tried(seed);
    const AveragedTrajectory trajectory = tried.trajectory();
    const double dt = trajectory.duration() / 4000;
    TrajectoryPoint before = trajectory.at(-dt);
    for (int k = 0; k <= 4001; ++k) {
      const TrajectoryPoint at = trajectory.at(k * dt);
      ASSERT_TRUE((at.qd.cwiseAbs().array() <= tried.limits.velocity.array() * (1 + 1e-9) + 1e-9).all());
      ASSERT_TRUE((at.qdd.cwiseAbs().array() <= tried.limits.acceleration.array() * (1 + 1e-6) + 1e-7).all());
      ASSERT_LE((at.qdd - before.qdd).cwiseAbs().maxCoeff(), dt * tried.jerk * (1 + 1e-6) + 1e-7) << "seed " << seed;
      // What may be between two samples: as much as accelerations and jerks change them by.
      const Eigen::VectorXd qd = 0.5 * dt * (before.qdd + at.qdd);
      ASSERT_LE((at.qd - before.qd - qd).cwiseAbs().maxCoeff(), 0.5 * dt * dt * tried.jerk + 1e-9) << "seed " << seed;
      const Eigen::VectorXd q = 0.5 * dt * (before.qd + at.qd);
      ASSERT_LE((at.q - before.q - q).cwiseAbs().maxCoeff(),
                0.5 * dt * dt * tried.limits.acceleration.maxCoeff() + 1e-9)
          << "seed " << seed;
      before = at;
    }
  }
}

TEST(JerkLimited, BeginsAndEndsAtRestAtTheEnds) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Case tried(seed);
    const AveragedTrajectory trajectory = tried.trajectory();
    const double end = trajectory.duration(), soon = 1e-6;
    EXPECT_EQ(trajectory.at(0.0).q, tried.waypoints.front());
    EXPECT_LT((trajectory.at(end).q - tried.waypoints.back()).norm(), 1e-9);
    EXPECT_EQ(trajectory.at(end).qd.norm(), 0.0);
    for (const double t : {soon, end - soon}) {
      EXPECT_LT(trajectory.at(t).qd.norm(), 1e-6) << "seed " << seed;
      EXPECT_LT(trajectory.at(t).qdd.norm(), 0.1) << "seed " << seed;
    }
    EXPECT_LT((trajectory.at(end - soon).q - tried.waypoints.back()).norm(), 1e-6);
  }
}

/// One joint, 1 rad, 1 rad/s, 2 rad/s²: 1.5 s without a limit of jerk, and with 80 rad/s³ a window of 2 · 2/80 s more.
TEST(JerkLimited, LineTakesTheWindowLonger) {
  const Waypoints one{Eigen::VectorXd::Constant(1, 0.0), Eigen::VectorXd::Constant(1, 1.0)};
  const MotionLimits limits{Eigen::VectorXd::Constant(1, 1.0), Eigen::VectorXd::Constant(1, 2.0)};
  const AveragedTrajectory trajectory = jerk_limited(one, curve_always, segment_never_free, limits, {.jerk = 80.0});
  EXPECT_NEAR(trajectory.duration(), 1.55, 1e-9);
  // Where the jerk is what counts, no more than 1.3 times the shortest time there is, ∛(32 · 1 rad/jerk).
  for (const double jerk : {0.1, 1.0, 4.0}) {
    const double shortest = std::cbrt(32.0 / jerk);
    const double duration = jerk_limited(one, curve_always, segment_never_free, limits, {.jerk = jerk}).duration();
    EXPECT_GE(duration, shortest * (1 - 1e-9));
    EXPECT_LE(duration, 1.3 * shortest) << jerk;
  }
}

TEST(JerkLimited, StaysWithinTheDeviation) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Case tried(seed);
    const AveragedTrajectory trajectory = tried.trajectory();
    for (int k = 0; k <= 1000; ++k) {
      const Eigen::VectorXd q = trajectory.at(trajectory.duration() * k / 1000).q;
      ASSERT_LE(distance_to(tried.waypoints, q), BlendOptions{}.deviation + 1e-3) << "seed " << seed;
    }
  }
}

/// What is not allowed to leave the path does not: it stops at every corner, and stays there for a window.
TEST(JerkLimited, StaysOnThePathWhereNothingElseIsFree) {
  double stopping = 0.0, rounding = 0.0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Case tried(seed);
    const AveragedTrajectory trajectory = tried.trajectory(segment_never_free);
    for (int k = 0; k <= 1000; ++k) {
      const TrajectoryPoint at = trajectory.at(trajectory.duration() * k / 1000);
      ASSERT_LT(distance_to(tried.waypoints, at.q), 1e-8) << "seed " << seed;
    }
    stopping += trajectory.duration();
    rounding += tried.trajectory().duration();
  }
  EXPECT_LT(rounding, 0.98 * stopping);
}

/// Everything off the path lies within the spread of a way that was asked for and allowed.
TEST(JerkLimited, LeavesThePathOnlyWhereAllowed) {
  struct Way {
    Eigen::VectorXd from, to, spread;
  };
  int left = 0, refused = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const Case tried(seed);
    // A half-space that cuts off the inner side of some corners.
    const Eigen::VectorXd out = Eigen::VectorXd::Ones(tried.waypoints.front().size()).normalized();
    std::vector<Way> allowed;
    const SegmentFree beside = [&](const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                                   const Eigen::VectorXd& spread) {
      const bool free = std::max(out.dot(from), out.dot(to)) + spread.sum() < 0.3;
      (free ? left : refused) += 1;
      if (free) allowed.push_back({from, to, spread});
      return free;
    };
    const AveragedTrajectory trajectory = tried.trajectory(beside);
    for (int k = 0; k <= 2000; ++k) {
      const Eigen::VectorXd q = trajectory.at(trajectory.duration() * k / 2000).q;
      if (distance_to(tried.waypoints, q) < 1e-8) continue;
      const bool within = std::any_of(allowed.begin(), allowed.end(), [&](const Way& way) {
        const Eigen::VectorXd along = way.to - way.from;
        const double t =
            along.squaredNorm() > 0 ? std::clamp(along.dot(q - way.from) / along.squaredNorm(), 0.0, 1.0) : 0.0;
        return ((q - way.from - t * along).cwiseAbs().array() <= 2.0 * way.spread.array()).all();
      });
      ASSERT_TRUE(within) << "seed " << seed << " sample " << k;
      ASSERT_LT(out.dot(q), 0.3);
    }
  }
  EXPECT_GT(left, 100);
  EXPECT_GT(refused, 10);
}

TEST(JerkLimited, EmptyPathTakesNoTime) {
  const MotionLimits limits{Eigen::VectorXd::Ones(2), Eigen::VectorXd::Ones(2)};
  const Waypoints still{Eigen::Vector2d(1, 2), Eigen::Vector2d(1, 2)};
  const AveragedTrajectory trajectory = jerk_limited(still, curve_always, segment_always_free, limits, {});
  EXPECT_TRUE(trajectory.empty());
  EXPECT_EQ(trajectory.duration(), 0.0);
}

}  // namespace
}  // namespace hecaton::planner
