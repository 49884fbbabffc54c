#include "planner/trajectory/stop_profile.hpp"

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

const JointLimits kLimits{joints({-3, -3}), joints({3, 3}), joints({1.5, 1.0}), joints({10, 5})};

TEST(StopProfile, SlowestJointDeterminesTheTime) {
  // 1.5/10 = 0.15 s and 0.5/5 = 0.1 s
  EXPECT_DOUBLE_EQ(stop_time(kLimits, joints({1.5, -0.5})), 0.15);
  // 1.5/10 = 0.15 s and 1/5 = 0.2 s
  EXPECT_DOUBLE_EQ(longest_stop_time(kLimits), 0.2);
}

TEST(StopProfile, KeepsTheDirectionAndRespectsEveryJoint) {
  const JointVector qd = joints({1.2, -0.8});  // T = max(0.12, 0.16) = 0.16 s
  const JointVector next = braking_velocity(kLimits, qd, 0.04);
  EXPECT_NEAR((next - joints({0.9, -0.6})).norm(), 0.0, 1e-12);  // · (1 − 0.04/0.16)
  EXPECT_EQ(braking_velocity(kLimits, qd, 0.16), joints({0, 0}));
}

TEST(StopProfile, RestPositionIsWhereStepsOfTheProfileEnd) {
  const JointVector q0 = joints({0.1, 0.2});
  JointVector q = q0;
  JointVector qd = joints({1.2, -0.8});
  const JointVector expected = rest_position(kLimits, q, qd);
  EXPECT_NEAR((expected - (q0 + 0.08 * joints({1.2, -0.8}))).norm(), 0.0, 1e-12);
  while (!qd.isZero()) {
    const JointVector next = braking_velocity(kLimits, qd, 0.001);
    q += 0.5 * (qd + next) * 0.001;
    qd = next;
  }
  EXPECT_NEAR((q - expected).norm(), 0.0, 1e-6);
}

}  // namespace
}  // namespace hecaton::planner
