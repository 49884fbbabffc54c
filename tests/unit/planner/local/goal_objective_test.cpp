#include "planner/local/goal_objective.hpp"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;
using test::kPeriod;

const JointLimits kUnequalLimits{joints({-3, -3}), joints({3, 3}), joints({1.0, 2.0}), joints({10, 10})};

TEST(GoalObjective, MovesStraightAtTheSlowestJointsSpeed) {
  // Direction (0.6, 0.8): joint 1 allows 1/0.6 = 1.67, joint 2 2/0.8 = 2.5; speed 1.67 → q̇ = (1, 1.333)
  const JointVector qd = goal_velocity(kUnequalLimits, joints({-1.2, -1.6}), joints({1.2, 1.6}), 0.01);
  EXPECT_NEAR((qd - joints({1.0, 4.0 / 3.0})).norm(), 0.0, 1e-12);
}

TEST(GoalObjective, IsZeroAtTheGoal) {
  EXPECT_TRUE(goal_velocity(kUnequalLimits, joints({1, 1}), joints({1, 1}), 0.01).isZero());
}

TEST(GoalObjective, ContinuousJointsTakeTheShorterDirection) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const JointLimits limits{joints({-kInfinity}), joints({kInfinity}), joints({1}), joints({10})};
  const JointVector way = joint_difference(limits, joints({3.0}), joints({-3.0}));
  EXPECT_NEAR(way[0], 2.0 * std::numbers::pi - 6.0, 1e-12);
}

// The approach never asks for more deceleration than the joints have, and arrives without overshoot.
TEST(GoalObjective, ArrivesWithinTheAccelerationLimits) {
  const JointVector goal = joints({1.0, 0.5});
  JointVector q = joints({-1.0, 0.0});
  JointVector qd = joints({0, 0});
  double way_left = (goal - q).norm();
  for (int step = 0; step < 1000; ++step) {
    const JointVector wanted = goal_velocity(kUnequalLimits, q, goal, kPeriod);
    const JointVector next = wanted.cwiseMax(qd - kUnequalLimits.acceleration * kPeriod)
                                 .cwiseMin(qd + kUnequalLimits.acceleration * kPeriod);
    if (step > 30) {
      ASSERT_NEAR((next - wanted).norm(), 0.0, 1e-9) << "step " << step;
    }
    q += 0.5 * (qd + next) * kPeriod;
    qd = next;
    ASSERT_LE((goal - q).norm(), way_left + 1e-9);
    way_left = (goal - q).norm();
  }
  EXPECT_LT(way_left, 1e-6);
}

// A goal that is as far ahead as approach_distance says is approached at just that speed.
TEST(GoalObjective, ApproachDistanceInvertsGoalVelocity) {
  const JointVector q = joints({0.1, -0.2});
  const JointVector direction = joints({0.6, -0.8});
  for (const double speed : {0.001, 0.05, 0.2, 0.5}) {
    const double distance = approach_distance(kUnequalLimits, direction, speed, kPeriod);
    EXPECT_NEAR(goal_velocity(kUnequalLimits, q, q + distance * direction, kPeriod).norm(), speed, 1e-9);
  }
}

}  // namespace
}  // namespace hecaton::planner
