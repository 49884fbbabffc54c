#include "planner/global/timed_path.hpp"

#include <gtest/gtest.h>

#include "planner/global/plan.hpp"
#include "tests/support/fcl_collision_checker.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::planner::global {
namespace {

/// A PUMA among boxes, and a path between two of its configurations.
struct Found {
  std::vector<WorldBody> world;
  Validity validity;
  Plan plan;

  Found(std::uint64_t seed, const PlanOptions& options) : Found(Random(seed), options) {}

 private:
  Found(Random random, const PlanOptions& options)
      : world(test::random_boxes(14, random)), validity({CellGeometry({test::puma()}, 0)}, world) {
    const Space space = space_of(validity, std::vector<double>(6, 0.0), std::vector<double>(6, 0.0));
    const auto draw = [&] {
      std::vector<float> q(space.stride);
      do {
        space.sample(random, q.data());
      } while (!validity.state_free(q.data()));
      return std::vector<double>(q.begin(), q.begin() + 6);
    };
    const std::vector<double> start = draw(), goal = draw();
    plan = global::plan(validity, start, goal, options);
  }
};

/// Checks the trajectory itself, not its path, by FCL and against the limits.
TEST(TimedPath, IsFreeWithinLimitsAndFasterThanWithStops) {
  int blends = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    PlanOptions options;
    options.budget.iterations = 20'000;
    const auto [world, validity, found] = Found(seed, options);
    if (!found.solved()) continue;
    const Trajectory trajectory = timed_path(validity, found.path);
    TimedPathOptions stopping;
    stopping.blend.deviation = 0.0;
    EXPECT_LE(trajectory.duration(), timed_path(validity, found.path, stopping).duration() * (1 + 1e-9));
    for (const PathPiece& piece : trajectory.pieces()) blends += piece.blend ? 1 : 0;
    test::FclCollisionChecker checker(validity, world);
    const MotionLimits limits = motion_limits(validity);
    for (int k = 0; k <= 1000; ++k) {
      const TrajectoryPoint at = trajectory.at(trajectory.duration() * k / 1000);
      ASSERT_FALSE(checker.collides(at.q.data())) << "seed " << seed << " sample " << k;
      ASSERT_TRUE((at.qd.cwiseAbs().array() <= limits.velocity.array() * (1 + 1e-9)).all());
      ASSERT_TRUE((at.qdd.cwiseAbs().array() <= limits.acceleration.array() * (1 + 1e-6)).all());
    }
    const Eigen::VectorXd first = trajectory.at(0).q;
    EXPECT_EQ(std::vector<double>(first.begin(), first.end()), found.path.front());
  }
  EXPECT_GT(blends, 10);
}

/// For proven paths; jerks by finite differences.
TEST(JerkLimitedPath, IsFreeAndWithinAllLimits) {
  int rounded = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    PlanOptions options;
    options.budget.iterations = 20'000;
    const auto [world, validity, found] = Found(seed, options);
    if (!found.solved()) continue;
    const double jerk = seed % 3 == 0 ? 1000.0 : seed % 3 == 1 ? 100.0 : 20.0;
    const AveragedTrajectory trajectory = jerk_limited_path(validity, found.path, jerk);
    for (const PathPiece& piece : trajectory.averaged().pieces()) rounded += piece.blend ? 1 : 0;
    EXPECT_GT(trajectory.duration(), timed_path(validity, found.path).duration());
    test::FclCollisionChecker checker(validity, world);
    const MotionLimits limits = motion_limits(validity);
    constexpr int kSamples = 3000;
    const double dt = trajectory.duration() / kSamples;
    TrajectoryPoint before = trajectory.at(0.0);
    for (int k = 0; k <= kSamples; ++k) {
      const TrajectoryPoint at = trajectory.at(k * dt);
      ASSERT_FALSE(checker.collides(at.q.data())) << "seed " << seed << " sample " << k;
      ASSERT_TRUE((at.qd.cwiseAbs().array() <= limits.velocity.array() * (1 + 1e-9)).all());
      ASSERT_TRUE((at.qdd.cwiseAbs().array() <= limits.acceleration.array() * (1 + 1e-6)).all());
      ASSERT_LE((at.qdd - before.qdd).cwiseAbs().maxCoeff(), jerk * dt * (1 + 1e-6) + 1e-7) << "seed " << seed;
      before = at;
    }
    const TrajectoryPoint end = trajectory.at(trajectory.duration());
    EXPECT_EQ(end.qd.norm(), 0.0);
    for (int j = 0; j < 6; ++j) EXPECT_NEAR(end.q[j], found.path.back()[j], 1e-9);
  }
  EXPECT_GT(rounded, 10);
}

TEST(TimedPath, BlendsKeepTheClearance) {
  // A corner around a ball; a blend would come closer to the ball.
  const Validity free({CellGeometry({test::puma()}, 0)}, {});
  const std::vector<std::vector<double>> corner{
      {0.0, -0.3, 1.5, 0, 0, 0}, {0.6, -0.3, 1.5, 0, 0, 0}, {0.6, -0.9, 1.5, 0, 0, 0}};
  const auto blended_length = [&](const Validity& validity, double clearance) {
    TimedPathOptions options;
    options.clearance = clearance;
    double length = 0.0;
    const Trajectory trajectory = timed_path(validity, corner, options);
    for (const PathPiece& piece : trajectory.pieces()) length += piece.blend ? piece.length : 0;
    return length;
  };
  EXPECT_GT(blended_length(free, 0.02), 0.1);
  // No point of the cell has this clearance, so no blend is possible.
  const WorldBody ball{world::Sphere{0.05}, Pose(Eigen::Translation3d(0.0, 0.0, 3.0)), "ball"};
  const Validity beside({CellGeometry({test::puma()}, 0)}, std::vector{ball});
  EXPECT_EQ(blended_length(beside, 5.0), 0.0);
  EXPECT_GT(blended_length(beside, 0.02), 0.1);
}

}  // namespace
}  // namespace hecaton::planner::global
