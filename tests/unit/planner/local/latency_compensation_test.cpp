// Extrapolation and least distances against numbers worked out by hand.
#include "planner/local/latency_compensation.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

const JointLimits kLimits{joints({-3, -3}), joints({3, 3}), joints({0.5, 0.5}), joints({4, 4})};

ArmObservation brought_forward(const JointLimits& limits, ArmObservation arm) {
  extrapolate(limits, arm);
  return arm;
}

TEST(Extrapolated, APlannedArmKeepsItsVelocityAsFarAsItsJointsGo) {
  const ArmObservation now = brought_forward(kLimits, {joints({1, 2.99}), joints({-0.4, 0.2}), 0.1, true, true});
  EXPECT_NEAR((now.q - joints({0.96, 3.0})).norm(), 0.0, 1e-12);
  EXPECT_EQ(now.qd, joints({-0.4, 0.2}));
  EXPECT_EQ(now.age, 0.1);
}

TEST(Extrapolated, AnArmThatDoesNotPlanIsOnItsStopProfile) {
  // T = 0.4/4 = 0.1 s. After 0.05 s: half the speed, 0.4 · (0.05 − 0.0125) = 0.015 m on.
  const ArmObservation half = brought_forward(kLimits, {joints({1, 0}), joints({-0.4, 0.2}), 0.05, true, false});
  EXPECT_NEAR((half.q - joints({0.985, 0.0075})).norm(), 0.0, 1e-12);
  EXPECT_NEAR((half.qd - joints({-0.2, 0.1})).norm(), 0.0, 1e-12);
  // At rest after 0.1 s, q̇ T/2 = 0.02 m on.
  const ArmObservation rest = brought_forward(kLimits, {joints({1, 0}), joints({-0.4, 0.2}), 0.3, true, false});
  EXPECT_NEAR((rest.q - joints({0.98, 0.01})).norm(), 0.0, 1e-12);
  EXPECT_EQ(rest.qd, joints({0, 0}));
}

TEST(Extrapolated, AnObstacleKeepsItsTwist) {
  world::ObstacleState then;
  then.velocity.linear = {0.2, 0, 0};
  then.velocity.angular = {0, 0, 1.0};
  then.age = 0.1;
  const world::ObstacleState now = extrapolated(then);
  EXPECT_NEAR((now.X_WO.translation() - Eigen::Vector3d(0.02, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(now.X_WO.linear()(1, 0), std::sin(0.1), 1e-12);
}

OwnArmFeedback moving(double age, bool follows, double setpoint_age) {
  return {{joints({1, 0}), joints({0.4, -0.2})}, age, follows, 1, setpoint_age};
}

TEST(DeadReckoned, TheDriveGoesToTheSetPointThatItHad) {
  const MeasuredState now = dead_reckoned(kLimits, moving(0.006, true, 0.002), 0.01);
  EXPECT_NEAR((now.q - joints({1.0024, -0.0012})).norm(), 0.0, 1e-12);
  EXPECT_EQ(now.qd, joints({0.4, -0.2}));
}

TEST(DeadReckoned, AndThenStops) {
  // 8 ms to the set-point; 50 ms of the stop, which takes 0.1 s.
  const MeasuredState now = dead_reckoned(kLimits, moving(0.058, true, 0.002), 0.01);
  EXPECT_NEAR((now.q - joints({1.0182, -0.0091})).norm(), 0.0, 1e-12);
  EXPECT_NEAR((now.qd - joints({0.2, -0.1})).norm(), 0.0, 1e-12);
  // One that was without set-points is on its stop already.
  const MeasuredState late = dead_reckoned(kLimits, moving(0.05, true, 0.02), 0.01);
  const MeasuredState held = dead_reckoned(kLimits, moving(0.05, false, 0.0), 0.01);
  EXPECT_NEAR((late.q - joints({1.015, -0.0075})).norm(), 0.0, 1e-12);
  EXPECT_EQ(held.q, late.q);
}

TEST(LeastDistance, FreshNewsIsExact) {
  EXPECT_DOUBLE_EQ(least_distance({.distance = 0.2, .other_acceleration = 10}), 0.2);
  EXPECT_DOUBLE_EQ(least_distance({.distance = 0.2, .own_speed = 1, .other_acceleration = 10}, 0.03, 3.0), 0.2);
}

TEST(LeastDistance, AccelerationBoundsTheStray) {
  EXPECT_DOUBLE_EQ(least_distance({.distance = 0.2, .age = 0.1, .other_acceleration = 4}), 0.18);
}

TEST(LeastDistance, TheOthersDamperBoundsItMore) {
  // Both at rest, 0.03 above dₛ: whatever its acceleration the other has left x e^(−kτ) = 0.03 e^(−0.3).
  const AgedPair rest{.distance = 0.06, .age = 0.1, .other_acceleration = 25};
  EXPECT_NEAR(least_distance(rest, 0.03, 3.0), 0.03 + 0.03 * std::exp(-0.3), 1e-12);
  // Nearer to dₛ nothing is left to fear.
  const AgedPair near{.distance = 0.03, .age = 0.1, .other_acceleration = 25};
  EXPECT_DOUBLE_EQ(least_distance(near, 0.03, 3.0), 0.03);
}

TEST(LeastDistance, NoMarginAgainstAnOtherThatComesAsFastAsItsDamperAllows) {
  // ẋ = −k x from x = 0.3: the other alone moves, at k x on average. Its mean speed over τ gives the expected distance.
  const double k = 3.0;
  const double age = 0.1;
  const double left = 0.3 * std::exp(-k * age);
  const AgedPair pair{.distance = 0.03 + left, .age = age, .other_speed = (0.3 - left) / age, .other_acceleration = 25};
  EXPECT_NEAR(least_distance(pair, 0.03, k), 0.03 + left, 1e-12);
}

TEST(LeastDistance, IsNeverMoreThanExpected) {
  // Deep inside dₛ the damper would push the other away: nothing to rely on.
  EXPECT_DOUBLE_EQ(least_distance({.distance = 0.01, .age = 0.1, .other_acceleration = 25}, 0.03, 3.0), 0.01);
}

}  // namespace
}  // namespace hecaton::planner
