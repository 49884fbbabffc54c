#include "planner/local/latency_compensation.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "planner/collision/cell_geometry.hpp"
#include "planner/local/random.hpp"
#include "planner/model/urdf_loader.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

const JointLimits kDelayedLimits{joints({-3, -3}), joints({3, 3}), joints({0.5, 0.5}), joints({4, 4})};

ArmObservation brought_forward(const JointLimits& limits, ArmObservation arm) {
  extrapolate(limits, arm);
  return arm;
}

TEST(Extrapolated, PlannedArmKeepsItsVelocityWithinPositionLimits) {
  const ArmObservation now = brought_forward(kDelayedLimits, {joints({1, 2.99}), joints({-0.4, 0.2}), 0.1, true, true});
  EXPECT_NEAR((now.q - joints({0.96, 3.0})).norm(), 0.0, 1e-12);
  EXPECT_EQ(now.qd, joints({-0.4, 0.2}));
  EXPECT_EQ(now.age, 0.1);
}

TEST(Extrapolated, ArmThatOthersMoveKeepsItsVelocityWithinPositionLimits) {
  ArmObservation seen{joints({1, 2.99}), joints({-0.4, 0.2}), 0.1, true, false};
  seen.foreign = true;
  EXPECT_NEAR((brought_forward(kDelayedLimits, seen).q - joints({0.96, 3.0})).norm(), 0.0, 1e-12);
}

TEST(Extrapolated, UnplannedArmFollowsItsStopProfile) {
  // T = 0.4/4 = 0.1 s. After 0.05 s: half the speed, 0.4 · (0.05 − 0.0125) = 0.015 m on.
  const ArmObservation half = brought_forward(kDelayedLimits, {joints({1, 0}), joints({-0.4, 0.2}), 0.05, true, false});
  EXPECT_NEAR((half.q - joints({0.985, 0.0075})).norm(), 0.0, 1e-12);
  EXPECT_NEAR((half.qd - joints({-0.2, 0.1})).norm(), 0.0, 1e-12);
  // At rest after 0.1 s, q̇ T/2 = 0.02 m on.
  const ArmObservation rest = brought_forward(kDelayedLimits, {joints({1, 0}), joints({-0.4, 0.2}), 0.3, true, false});
  EXPECT_NEAR((rest.q - joints({0.98, 0.01})).norm(), 0.0, 1e-12);
  EXPECT_EQ(rest.qd, joints({0, 0}));
}

TEST(Extrapolated, ObstacleKeepsItsTwist) {
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

TEST(DeadReckoned, DriveMovesToItsLastSetPoint) {
  const MeasuredState now = dead_reckoned(kDelayedLimits, moving(0.006, true, 0.002), 0.01);
  EXPECT_NEAR((now.q - joints({1.0024, -0.0012})).norm(), 0.0, 1e-12);
  EXPECT_EQ(now.qd, joints({0.4, -0.2}));
}

TEST(DeadReckoned, DriveStopsAfterItsLastSetPoint) {
  // 8 ms to the set-point; 50 ms of the stop, which takes 0.1 s.
  const MeasuredState now = dead_reckoned(kDelayedLimits, moving(0.058, true, 0.002), 0.01);
  EXPECT_NEAR((now.q - joints({1.0182, -0.0091})).norm(), 0.0, 1e-12);
  EXPECT_NEAR((now.qd - joints({0.2, -0.1})).norm(), 0.0, 1e-12);
  // One that was without set-points is on its stop already.
  const MeasuredState late = dead_reckoned(kDelayedLimits, moving(0.05, true, 0.02), 0.01);
  const MeasuredState held = dead_reckoned(kDelayedLimits, moving(0.05, false, 0.0), 0.01);
  EXPECT_NEAR((late.q - joints({1.015, -0.0075})).norm(), 0.0, 1e-12);
  EXPECT_EQ(held.q, late.q);
}

TEST(LeastDistance, IsExactForAgeZero) {
  EXPECT_DOUBLE_EQ(least_distance({.distance = 0.2, .other_acceleration = 10}), 0.2);
  EXPECT_DOUBLE_EQ(least_distance({.distance = 0.2, .own_speed = 1, .other_acceleration = 10}, 0.03, 3.0), 0.2);
}

TEST(LeastDistance, SubtractsWhatAccelerationCanAdd) {
  EXPECT_DOUBLE_EQ(least_distance({.distance = 0.2, .age = 0.1, .other_acceleration = 4}), 0.18);
}

TEST(LeastDistance, IsTighterWhenTheOtherArmKeepsItsDamper) {
  // Both at rest, 0.03 above dₛ: for any acceleration of the other, the remainder is x e^(−kτ) = 0.03 e^(−0.3).
  const AgedPair rest{.distance = 0.06, .age = 0.1, .other_acceleration = 25};
  EXPECT_NEAR(least_distance(rest, 0.03, 3.0), 0.03 + 0.03 * std::exp(-0.3), 1e-12);
  // At dₛ no further approach is possible.
  const AgedPair near{.distance = 0.03, .age = 0.1, .other_acceleration = 25};
  EXPECT_DOUBLE_EQ(least_distance(near, 0.03, 3.0), 0.03);
}

TEST(LeastDistance, NeedsNoMarginWhenTheOtherArmMovesAtItsDamperLimit) {
  // ẋ = −k x from x = 0.3: the other alone moves, at k x on average. Its mean speed over τ gives the expected distance.
  const double k = 3.0;
  const double age = 0.1;
  const double left = 0.3 * std::exp(-k * age);
  const AgedPair pair{.distance = 0.03 + left, .age = age, .other_speed = (0.3 - left) / age, .other_acceleration = 25};
  EXPECT_NEAR(least_distance(pair, 0.03, k), 0.03 + left, 1e-12);
}

TEST(LeastDistance, NeverExceedsTheExpectedDistance) {
  // Deep inside dₛ the damper would push the other away; the bound does not rely on that.
  EXPECT_DOUBLE_EQ(least_distance({.distance = 0.01, .age = 0.1, .other_acceleration = 25}, 0.03, 3.0), 0.01);
}

}  // namespace
namespace {

using test::joints;

class SetpointLogTest : public testing::Test {
 protected:
  SetpointLogTest() { log_.sent(7, {joints({1, 0}), joints({0.4, -0.2})}); }

  JointVector reference(double age) { return log_.reference(7, age).value().q; }

  SetpointLog log_{kDelayedLimits, 0.01};
};

TEST_F(SetpointLogTest, ReferenceInterpolatesUntilTheSetPointIsDue) {
  EXPECT_NEAR((reference(0.0) - joints({0.996, 0.002})).norm(), 0.0, 1e-12);
  EXPECT_EQ(reference(0.01), joints({1, 0}));
}

TEST_F(SetpointLogTest, ReferenceFollowsStopProfileOnceOverdue) {
  // T = 0.4/4 = 0.1 s: 0.05 s later 0.4 · (0.05 − 0.0125) on, after T at rest 0.4 · 0.05 on.
  EXPECT_NEAR((reference(0.06) - joints({1.015, -0.0075})).norm(), 0.0, 1e-12);
  EXPECT_NEAR((reference(1.0) - joints({1.02, -0.01})).norm(), 0.0, 1e-12);
  EXPECT_EQ(log_.reference(7, 1.0).value().qd, joints({0, 0}));
}

TEST_F(SetpointLogTest, NegativeAgeLeadsBackToEarlierSetPoints) {
  log_.sent(8, {joints({1.004, -0.002}), joints({0.4, -0.2})});
  EXPECT_NEAR((log_.reference(8, -0.004).value().q - reference(0.006)).norm(), 0.0, 1e-12);
  // Before the oldest one it goes on backwards at its velocity.
  EXPECT_NEAR((log_.reference(8, -0.03).value().q - joints({0.988, 0.006})).norm(), 0.0, 1e-12);
}

TEST_F(SetpointLogTest, ReturnsNothingForUnknownOrOldNumbers) {
  EXPECT_FALSE(log_.reference(0, 0.0));
  EXPECT_FALSE(log_.reference(6, 0.0));
  EXPECT_FALSE(log_.reference(7 + 64, 0.0));
  log_.sent(7 + 64, {joints({2, 0}), joints({0, 0})});
  EXPECT_FALSE(log_.reference(7, 0.0)) << "64 set-points ago";
}

}  // namespace
namespace {

using test::joints;

constexpr double kStep = 1e-3;  // [s]

double draw(Random& random, double bound) {
  return random.uniform(-bound, bound);
}

/// Where an arm rests that accelerates at random, in bursts, for `moved_for`, then goes on its stop profile.
JointVector rest_of_adversary(const JointLimits& limits, JointVector q, JointVector qd, double moved_for,
                              Random& random) {
  JointVector push = JointVector::Zero(q.size());
  for (double t = 0.0; t + 0.5 * kStep < moved_for; t += kStep) {
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      // Mostly at maximum acceleration, to reach the border of the set.
      if (random.uniform() < 0.03) push[j] = limits.acceleration[j] * (random.uniform() < 0.8 ? 1.0 : -1.0);
      const double next = std::clamp(qd[j] + push[j] * kStep, -limits.velocity[j], limits.velocity[j]);
      q[j] += 0.5 * (qd[j] + next) * kStep;
      qd[j] = next;
    }
  }
  return rest_position(limits, q, qd).cwiseMax(limits.lower).cwiseMin(limits.upper);
}

TEST(ReachableStopSet, IsAPointForAnArmAtRestThatNeverMoves) {
  const JointLimits limits = test::planar_point().limits;
  const ReachableStopSet region = reachable_stop_set(limits, joints({0.3, -1.0}), joints({0, 0}), 0.0);
  EXPECT_EQ(region.q, joints({0.3, -1.0}));
  EXPECT_EQ(region.position_uncertainty, joints({0, 0}));
}

// From rest, 0.1 s at 4 m/s²: 20 mm and 0.4 m/s; then as long and as far to a stop.
TEST(ReachableStopSet, MatchesValuesComputedByHand) {
  const JointLimits limits = test::planar_point().limits;
  ReachableStopSet region = reachable_stop_set(limits, joints({0, 0}), joints({0, 0}), 0.1);
  EXPECT_NEAR(region.position_uncertainty[0], 0.04, 1e-12);
  EXPECT_NEAR(region.q[0], 0.0, 1e-12);
  // At 0.5 m/s already, the limit: 50 mm and 31.25 mm on; or in 0.1 s down to 0.1 m/s: 30 mm on.
  region = reachable_stop_set(limits, joints({0, 0}), joints({0.5, 0}), 0.1);
  EXPECT_NEAR(region.q[0] + region.position_uncertainty[0], 0.08125, 1e-12);
  EXPECT_NEAR(region.q[0] - region.position_uncertainty[0], 0.03, 1e-12);
}

TEST(ReachableStopSet, EndsAtTheJointLimits) {
  const JointLimits limits = test::planar_point().limits;
  const ReachableStopSet region = reachable_stop_set(limits, joints({2.99, 0}), joints({0.5, 0}), 0.5);
  EXPECT_LE(region.q[0] + region.position_uncertainty[0], 3.0 + 1e-12);
}

TEST(ReachableStopSet, ContainsEveryMotionWithinLimits) {
  const JointLimits limits = test::planar_point().limits;
  Random random(3);
  double fullest = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    const JointVector q = joints({draw(random, 2.9), draw(random, 2.9)});
    const JointVector qd = joints({draw(random, 0.5), draw(random, 0.5)});
    const double moved_for = 0.3 * random.uniform();
    const ReachableStopSet region = reachable_stop_set(limits, q, qd, moved_for);
    const double braked_after = moved_for * (random.uniform() < 0.5 ? 1.0 : random.uniform());
    const JointVector rest = rest_of_adversary(limits, q, qd, braked_after, random);
    const JointVector away = (rest - region.q).cwiseAbs();
    ASSERT_TRUE((away.array() <= region.position_uncertainty.array() + 1e-3).all())
        << "trial " << trial;  // steps of 1 ms
    fullest = std::max(fullest, away.cwiseQuotient(region.position_uncertainty.cwiseMax(1e-3)).maxCoeff());
  }
  EXPECT_GT(fullest, 0.95) << "the set is too wide: no motion comes near its border";
}

TEST(LongestLevers, BoundTheMotionOfEveryPoint) {
  Arm arm;
  arm.name = "arm";
  arm.model = load_urdf(HECATON_SOURCE_DIR "/deploy/cells/urdf/puma560.urdf");
  arm.limits = arm.model->limits;
  const CellGeometry geometry({arm}, 0);
  const int n = arm.model->joints();
  Random random(4);
  Kinematics centre;
  Kinematics there;
  double fullest = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    JointVector q(n);
    JointVector position_uncertainty(n);
    JointVector moved(n);
    for (int j = 0; j < n; ++j) {
      q[j] = random.uniform(-2.0, 2.0);
      position_uncertainty[j] = 0.5 * random.uniform();
      moved[j] = q[j] + position_uncertainty[j] * (random.uniform() < 0.5 ? 1.0 : random.uniform(-1.0, 1.0));
    }
    forward_kinematics(*arm.model, arm.X_WB, q, centre);
    forward_kinematics(*arm.model, arm.X_WB, moved, there);
    for (const Body& body : geometry.own_bodies()) {
      const double extent = body.bound.centre.norm() + body.bound.radius;
      const double most = longest_levers(arm, body.link, extent).dot(position_uncertainty);
      const Eigen::Vector3d direction = Eigen::Vector3d(draw(random, 1), draw(random, 1), draw(random, 1)).normalized();
      const Eigen::Vector3d point = body.bound.centre + body.bound.radius * direction;
      const double way = (there.X_WL[body.link] * point - centre.X_WL[body.link] * point).norm();
      ASSERT_LE(way, most + 1e-12) << arm.model->links[body.link].name;
      if (most > 0.0) fullest = std::max(fullest, way / most);
    }
  }
  EXPECT_GT(fullest, 0.5);
}

}  // namespace
}  // namespace hecaton::planner
