// Distances from the volume that a moving body sweeps.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "planner/collision/convex_distance.hpp"
#include "planner/collision/exact_distance.hpp"
#include "random_shapes.hpp"

namespace hecaton::planner {
namespace {

using Eigen::Vector3d;
using test::uniform;

ShapeDistance sweep_between(const world::Shape& a, const world::Pose& X_WA, const world::Shape& b,
                            const world::Pose& X_WB, const Sweep& sweep) {
  const SweptCore core_a = make_swept_core(a);
  const SweptCore core_b = make_swept_core(b);
  return swept(sweep_distance(core_a, X_WA, core_b, X_WB, sweep), core_a.radius, core_b.radius);
}

world::Pose at(double x, double y, double z) {
  return world::pose_from_xyz_rpy({x, y, z}, Vector3d::Zero());
}

TEST(SweepDistance, IsMeasuredAbeamOfAPassingBall) {
  const auto d = sweep_between(world::Sphere{0.1}, at(0, 0, 0), world::Sphere{0.2}, at(-1, 0.5, 0), {{3, 0, 0}});
  EXPECT_NEAR(d.distance, 0.2, 1e-9);
  EXPECT_LT((d.n_W - Vector3d::UnitY()).norm(), 1e-6);
  EXPECT_LT((d.p_a_W - Vector3d(0, 0.1, 0)).norm(), 1e-6);
}

TEST(SweepDistance, IsMeasuredAtTheEndOfAShortWay) {
  const auto d = sweep_between(world::Sphere{0.1}, at(0, 0, 0), world::Sphere{0.2}, at(-1, 0, 0), {{0.5, 0, 0}});
  EXPECT_NEAR(d.distance, 0.2, 1e-9);
  EXPECT_LT((d.n_W + Vector3d::UnitX()).norm(), 1e-6);
}

TEST(SweepDistance, UncertaintyGrowsAlongTheWay) {
  // Balls of 0.1 and 0.3 around x = −1 and x = 1: their hull's side rises by (0.3 − 0.1)/2 = sin β. Its normal is
  // (−sin β, cos β): the side is 0.2 from the origin, and the ball's centre 0.6 cos β.
  const auto d =
      sweep_between(world::Sphere{0.1}, at(0, 0.6, 0), world::Sphere{1e-9}, at(-1, 0, 0), {{2, 0, 0}, 0.1, 0.3});
  EXPECT_NEAR(d.distance, 0.6 * std::sqrt(1.0 - 0.01) - 0.2 - 0.1, 1e-8);
}

TEST(SweepDistance, IsZeroWhenTheWayPassesThrough) {
  const auto d = sweep_between(world::Sphere{0.1}, at(0, 0, 0), world::Box{{0.1, 0.1, 0.1}}, at(-1, 0, 0), {{3, 0, 0}});
  EXPECT_LE(d.distance, 0.0);
}

// Samples of a straight motion: the body is never nearer than the distance, and as near at one instant.
TEST(SweepDistance, IsTheMinimumOnTheWay) {
  test::Random random(3);
  int apart = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto a = test::random_shape(static_cast<test::Kind>(trial % test::kKinds), random);
    const auto b = test::random_shape(static_cast<test::Kind>(trial / test::kKinds % test::kKinds), random);
    const world::Pose X_WA = test::random_pose(random, 1.0);
    const world::Pose X_WB = test::random_pose(random, 1.0);
    const Vector3d way(uniform(random, -2, 2), uniform(random, -2, 2), uniform(random, -2, 2));
    const auto d = sweep_between(a, X_WA, b, X_WB, {way});
    if (d.distance <= 0.0) continue;
    ++apart;
    constexpr int kSamples = 200;
    double least = 1e9;
    for (int i = 0; i <= kSamples; ++i) {
      world::Pose then = X_WB;
      then.translation() += way * i / kSamples;
      least = std::min(least, shape_distance(a, X_WA, b, then).distance);
    }
    ASSERT_LE(d.distance, least + 1e-6) << "trial " << trial;
    ASSERT_GE(d.distance, least - 0.5 * way.norm() / kSamples) << "trial " << trial;
  }
  EXPECT_GT(apart, 500);
}

// The claim of docs/explanation/0010-passing-obstacles.md, for all motions within the acceleration.
TEST(SweepDistance, BoundsAllMotionsWithinTheAcceleration) {
  test::Random random(4);
  int apart = 0;
  double tightest = 1.0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto a = test::random_shape(static_cast<test::Kind>(trial % test::kKinds), random);
    const auto b = test::random_shape(static_cast<test::Kind>(trial / test::kKinds % test::kKinds), random);
    const world::Pose X_WA = test::random_pose(random, 1.0);
    const world::Pose X_WB = test::random_pose(random, 1.0);
    const Vector3d velocity(uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, -3, 3));
    const double acceleration = uniform(random, 0.0, 20.0);
    const double age = uniform(random, 0.0, 0.05);
    const double seconds = uniform(random, 0.05, 0.2);
    const double end = age + seconds;
    const auto d = sweep_between(a, X_WA, b, X_WB,
                                 {velocity * seconds, 0.5 * acceleration * age * age, 0.5 * acceleration * end * end});
    if (d.distance <= 0.0) continue;
    ++apart;
    // It accelerates one way until some instant and another way from then on; X_WB is where it should be at `age`.
    const Vector3d first = acceleration * (test::random_pose(random, 1.0).linear() * Vector3d::UnitX());
    const Vector3d then = trial % 2 == 0 ? Vector3d(-acceleration * d.n_W)
                                         : Vector3d(acceleration * (test::random_pose(random, 1.0).linear().col(0)));
    const double change = trial % 2 == 0 ? 0.0 : uniform(random, 0.0, end);
    constexpr int kSteps = 200;
    Vector3d off = Vector3d::Zero();
    Vector3d gained = Vector3d::Zero();
    const double dt = end / kSteps;
    for (int i = 1; i <= kSteps; ++i) {
      const Vector3d& now = (i - 1) * dt < change ? first : then;
      off += gained * dt + 0.5 * now * dt * dt;
      gained += now * dt;
      if (i * dt < age) continue;
      world::Pose X = X_WB;
      X.translation() += velocity * (i * dt - age) + off;
      const double distance = shape_distance(a, X_WA, b, X).distance;
      ASSERT_GE(distance, d.distance - 1e-6) << "trial " << trial;
      tightest = std::min(tightest, distance - d.distance);
    }
  }
  EXPECT_GT(apart, 500);
  EXPECT_LT(tightest, 1e-3) << "the bound must be tight";
}

}  // namespace
}  // namespace hecaton::planner
