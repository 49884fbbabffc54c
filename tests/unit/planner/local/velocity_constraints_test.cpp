#include "planner/local/velocity_constraints.hpp"

#include <gtest/gtest.h>

#include "planner/local/random.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

const JointLimits kLimits{joints({-1, -1}), joints({1, 1}), joints({1.5, 1.5}), joints({10, 10})};
using test::kPeriod;

TEST(VelocityBounds, EqualVelocityLimitsFarFromPositionLimits) {
  const VelocityBounds bounds = speed_and_position_bounds(kLimits, joints({0, 0}), kPeriod);
  EXPECT_EQ(bounds.upper, joints({1.5, 1.5}));
  EXPECT_EQ(bounds.lower, joints({-1.5, -1.5}));
}

TEST(VelocityBounds, AllowOnlyReturnOutsidePositionLimits) {
  const VelocityBounds bounds = speed_and_position_bounds(kLimits, joints({1.05, 0}), kPeriod);
  EXPECT_LT(bounds.upper[0], 0.0);
  EXPECT_EQ(bounds.lower[0], -1.5);
}

// Property: motion at the bounds, in random changing directions, never leaves the limits.
TEST(VelocityBounds, MotionAtTheBoundsNeverCrossesAPositionLimit) {
  Random random(5);
  JointVector q = joints({0, 0});
  JointVector qd = joints({0, 0});
  double closest = 1.0;
  for (int step = 0; step < 200'000; ++step) {
    const JointVector braking = braking_velocity(kLimits, qd, kPeriod);
    const VelocityBounds bounds = intersect(speed_and_position_bounds(kLimits, q, kPeriod),
                                            acceleration_bounds(kLimits, qd, braking, kPeriod), braking);
    JointVector next(2);
    const bool upwards[2] = {(step / 150) % 2 == 0, (step / 220) % 2 == 0};
    for (int j = 0; j < 2; ++j) next[j] = upwards[j] ? bounds.upper[j] : bounds.lower[j];
    if (random.uniform() < 0.02) next = braking;
    ASSERT_TRUE(((next - qd).cwiseAbs().array() <= kLimits.acceleration.array() * kPeriod + 1e-12).all());
    q += 0.5 * (qd + next) * kPeriod;
    qd = next;
    ASSERT_LE(q.cwiseAbs().maxCoeff() - 1.0, 1e-6) << "step " << step;
    closest = std::min(closest, 1.0 - q.cwiseAbs().maxCoeff());
  }
  EXPECT_LT(closest, 1e-3);  // it did come to the limit
}

}  // namespace
}  // namespace hecaton::planner
