#include "planner/simulation/arm_model.hpp"

#include <gtest/gtest.h>

#include "planner/local/random.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

const JointLimits kLimits{joints({-1, -1}), joints({1, 1}), joints({1.5, 1.5}), joints({10, 10})};
constexpr double kStep = 0.002;
constexpr double kPeriod = 0.01;
constexpr double kTimeout = 0.05;

TEST(ArmModel, RestsUntilCommanded) {
  ArmModel arm(kLimits, joints({0.2, -0.3}), kTimeout);
  for (int i = 0; i < 100; ++i) arm.step(kStep);
  EXPECT_EQ(arm.mode(), DriveMode::kIdle);
  EXPECT_EQ(arm.q(), joints({0.2, -0.3}));
}

// The planner accelerates at the limit and integrates with the trapezoid rule.
TEST(ArmModel, TracksRampAndConstantVelocity) {
  ArmModel arm(kLimits, joints({0, 0}), kTimeout);
  JointVector q = joints({0, 0});
  JointVector qd = joints({0, 0});
  for (int period = 0; period < 40; ++period) {
    const JointVector next = (qd + joints({0.1, -0.05})).cwiseMin(joints({1.0, 1.0})).cwiseMax(joints({-0.5, -0.5}));
    q += 0.5 * (qd + next) * kPeriod;
    qd = next;
    arm.command(q, qd, kPeriod);
    for (int i = 0; i < 5; ++i) arm.step(kStep);
    ASSERT_LT((arm.q() - q).norm(), 1e-3) << "period " << period;
  }
  EXPECT_EQ(arm.mode(), DriveMode::kTracking);
  EXPECT_NEAR(arm.qd()[0], 1.0, 0.05);
}

// The stop from 0.5 rad/s takes 0.5²/(2 · 10) rad; the time-out passes meanwhile.
TEST(ArmModel, StopsWhenCommandsCease) {
  ArmModel arm(kLimits, joints({0, 0}), kTimeout);
  JointVector q = joints({0, 0});
  JointVector qd = joints({0, 0});
  for (int period = 0; period < 20; ++period) {
    const JointVector next = (qd + joints({0.1, 0.0})).cwiseMin(joints({0.5, 0.5}));
    q += 0.5 * (qd + next) * kPeriod;
    qd = next;
    arm.command(q, qd, kPeriod);
    for (int i = 0; i < 5; ++i) arm.step(kStep);
  }
  const double at_silence = arm.q()[0];
  int steps = 0;
  while (arm.mode() != DriveMode::kIdle) {
    arm.step(kStep);
    ASSERT_LT(++steps, 1000);
  }
  EXPECT_NEAR(arm.q()[0] - at_silence, 0.0125, 0.5 * 2 * kStep);
  EXPECT_TRUE(arm.qd().isZero());
}

// Until a late command arrives, the arm follows the stop from the last set-point. Then it resumes without overshoot.
TEST(ArmModel, StaysOnTheStopUntilALateCommand) {
  for (const double late : {0.002, 0.01, 0.03, 0.045}) {
    ArmModel arm(kLimits, joints({-0.9, 0}), kTimeout);
    JointVector q = joints({-0.9, 0});
    JointVector qd = joints({0, 0});
    double furthest = -1.0;
    for (int period = 0; period < 60; ++period) {
      const JointVector next = period < 40 ? (qd + joints({0.1, 0.0})).cwiseMin(joints({1.0, 1.0}))
                                           : JointVector((qd - joints({0.08, 0.0})).cwiseMax(joints({0.0, 0.0})));
      q += 0.5 * (qd + next) * kPeriod;
      qd = next;
      arm.command(q, qd, kPeriod);
      const double rest = q[0] + qd[0] * qd[0] / 20.0;  // v²/(2a)
      furthest = std::max(furthest, rest);
      const double silence = kPeriod + (period == 12 ? late : 0.0);
      for (double t = 0.0; t < silence - 1e-9; t += kStep) {
        arm.step(kStep);
        ASSERT_LE(arm.q()[0], furthest + 2e-3) << "late " << late << ", period " << period;
      }
    }
    EXPECT_EQ(arm.mode(), DriveMode::kTracking);
    EXPECT_NEAR(arm.q()[0], q[0], 2e-3) << "late " << late;
  }
}

TEST(ArmModel, StopDropsTheSetPoint) {
  ArmModel arm(kLimits, joints({0, 0}), kTimeout);
  arm.command(joints({0.01, 0}), joints({0.1, 0}), kPeriod);
  arm.step(kStep);
  arm.stop();
  EXPECT_EQ(arm.mode(), DriveMode::kStopping);
  arm.step(kStep);
  arm.step(kStep);
  EXPECT_EQ(arm.mode(), DriveMode::kIdle);
}

// Property: for any commands, the limits of position, velocity and acceleration hold in every step.
TEST(ArmModel, KeepsLimitsForAnyCommand) {
  Random random(9);
  ArmModel arm(kLimits, joints({0, 0}), kTimeout);
  const double reach = 1.5 * (kTimeout + kPeriod);
  int followed = 0;
  for (int period = 0; period < 20'000; ++period) {
    if (random.uniform() < 0.8) {
      // Mostly within reach, sometimes anywhere, also outside the limits.
      const double far = random.uniform() < 0.9 ? reach : 3.0;
      const JointVector off = joints({random.uniform(-far, far), random.uniform(-far, far)});
      const JointVector wild = joints({random.uniform(-9, 9), random.uniform(-9, 9)});
      followed += arm.command(arm.q() + off, wild, kPeriod) ? 1 : 0;
    }
    for (int i = 0; i < 5; ++i) {
      const JointVector before = arm.qd();
      arm.step(kStep);
      ASSERT_LE(arm.q().cwiseAbs().maxCoeff(), 1.0);
      ASSERT_LE(arm.qd().cwiseAbs().maxCoeff(), 1.5 + 1e-12);
      for (int j = 0; j < 2; ++j) {
        const bool at_end_stop = std::abs(arm.q()[j]) == 1.0;  // the stop itself is harder than the drive
        if (!at_end_stop) {
          ASSERT_LE(std::abs(arm.qd()[j] - before[j]), 10 * kStep + 1e-12);
        }
      }
    }
  }
  EXPECT_GT(arm.clamped(), 1000U);
  EXPECT_GT(followed, 10'000);
}

TEST(ArmModel, RejectsUnreachableSetPoint) {
  ArmModel arm(kLimits, joints({0, 0}), kTimeout);
  const double reach = 1.5 * (kTimeout + kPeriod);
  EXPECT_FALSE(arm.command(joints({0, reach + 1e-6}), joints({0, 0}), kPeriod));
  EXPECT_EQ(arm.mode(), DriveMode::kIdle);
  EXPECT_TRUE(arm.command(joints({0, reach - 1e-6}), joints({0, 0}), kPeriod));
  EXPECT_EQ(arm.mode(), DriveMode::kTracking);
  arm.step(kStep);
  EXPECT_FALSE(arm.command(joints({-reach - 0.01, 0}), joints({0, 0}), kPeriod));
  EXPECT_EQ(arm.mode(), DriveMode::kStopping) << "the previous set-point is dropped as well";
}

}  // namespace
}  // namespace hecaton::planner
