#include "planner/simulation/servo.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "planner/simulation/arm_model.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

const JointLimits kWideLimits{joints({-9, -9}), joints({9, 9}), joints({1.5, 1.5}), joints({10, 10})};
constexpr double kServoStep = 0.002;  // [s]

JointState at_constant_speed(double now) {
  return {joints({1.0 * now, -0.5 * now}), joints({1.0, -0.5})};
}

TEST(Servo, IsBehindARampByItsDelayAsEachController) {
  for (const auto& [name, servo] : servo_presets()) {
    Servo arm(kWideLimits, servo, joints({0, 0}), 3);
    double mean = 0.0;
    int samples = 0;
    for (int i = 1; i <= 2000; ++i) {
      const double now = i * kServoStep;
      arm.follow(at_constant_speed(now), kServoStep);
      if (now < 1.0) continue;
      const double behind = at_constant_speed(now).q[0] - arm.state().q[0];
      EXPECT_NEAR(behind, servo.delay(), 1e-3) << name;
      mean += at_constant_speed(now).q[0] - arm.measured().q[0];
      ++samples;
    }
    EXPECT_NEAR(mean / samples, servo.delay(), 1e-4) << name;
  }
}

TEST(Servo, EndsAtARestingSetPoint) {
  for (const auto& [name, servo] : servo_presets()) {
    Servo arm(kWideLimits, servo, joints({0, 0}), 3);
    const JointState set_point{joints({0.3, -0.2}), joints({0, 0})};
    for (int i = 0; i < 1000; ++i) arm.follow(set_point, kServoStep);
    EXPECT_LT((arm.state().q - set_point.q).norm(), 1e-6) << name;
    EXPECT_LT((arm.measured().q - set_point.q).cwiseAbs().maxCoeff(), 3.0 * servo.noise + servo.resolution) << name;
  }
}

TEST(Servo, OvershootsAsASecondOrderOnly) {
  const auto highest_with = [](double damping) {
    Servo arm(kWideLimits, {.lag = 0.04, .damping = damping}, joints({0, 0}), 1);
    double highest = 0.0;
    for (int i = 0; i < 500; ++i) {
      arm.follow({joints({1, 0}), joints({0, 0})}, kServoStep);
      highest = std::max(highest, arm.state().q[0]);
    }
    return highest;
  };
  EXPECT_LE(highest_with(0.0), 1.0);
  EXPECT_NEAR(highest_with(0.5), 1.163, 0.002);  // 1 + exp(−π ζ/√(1 − ζ²))
}

TEST(Servo, TakesSetPointsInItsOwnPeriodWithinTheLimits) {
  const ServoParameters own_period{.period = 0.02};
  EXPECT_FALSE(own_period.perfect());
  Servo arm(kWideLimits, own_period, joints({0, 0}), 1);
  arm.follow({joints({0, 0}), joints({0, 0})}, kServoStep);
  const JointState later{joints({0.05, 0}), joints({0, 0})};
  for (int i = 2; i <= 500; ++i) {
    const double before = arm.state().qd[0];
    arm.follow(later, kServoStep);
    const bool taken = i >= 10;  // the second cycle begins after 20 ms
    EXPECT_EQ(arm.state().q[0] > 0.0, taken) << i;
    EXPECT_LE(std::abs(arm.state().qd[0] - before), 10.0 * kServoStep + 1e-9) << i;
  }
  EXPECT_NEAR(arm.state().q[0], 0.05, 1e-6);
}

TEST(Servo, IsNotBehindARampByItsPeriod) {
  Servo arm(kWideLimits, {.period = 0.02}, joints({0, 0}), 1);
  for (int i = 1; i <= 1000; ++i) {
    arm.follow(at_constant_speed(i * kServoStep), kServoStep);
    if (i <= 500) continue;
    EXPECT_NEAR(arm.state().q[0], 1.0 * i * kServoStep, 1e-4);
  }
}

TEST(Servo, MeasuresInSteps) {
  Servo arm(kWideLimits, {.noise = 1e-3, .resolution = 5e-4}, joints({0.1, 0}), 1);
  double farthest = 0.0;
  for (int i = 0; i < 200; ++i) {
    arm.follow({joints({0.1, 0}), joints({0, 0})}, kServoStep);
    const double steps = arm.measured().q[0] / 5e-4;
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
    farthest = std::max(farthest, std::abs(arm.measured().q[0] - 0.1));
  }
  EXPECT_GT(farthest, 1e-3);
  EXPECT_DOUBLE_EQ(arm.state().q[0], 0.1) << "the arm itself does not tremble";
}

TEST(Servo, BrakesAtOnceAndDropsItsSetPoints) {
  Servo arm(kWideLimits, {.dead_time = 0.1, .lag = 0.02}, joints({0, 0}), 1);
  double now = 0.0;
  for (int i = 0; i < 500; ++i) arm.follow(at_constant_speed(now += kServoStep), kServoStep);
  const double begin = arm.state().q[0];
  for (int i = 0; i < 100; ++i) arm.brake(kServoStep);
  EXPECT_TRUE(arm.state().qd.isZero());
  EXPECT_NEAR(arm.state().q[0] - begin, 1.0 / (2.0 * 10.0), 2e-3);
  const double rest = arm.state().q[0];
  arm.follow({arm.state().q, joints({0, 0})}, kServoStep);
  EXPECT_NEAR(arm.state().q[0], rest, 1e-9);
}

TEST(Servo, OfADefaultArmIsPerfect) {
  EXPECT_TRUE(ServoParameters().perfect());
  ArmModel plain(kWideLimits, joints({0, 0}), 0.05);
  ArmModel servoed(kWideLimits, joints({0, 0}), 0.05, {}, 1);
  for (ArmModel* arm : {&plain, &servoed}) {
    arm->command(joints({0.001, 0}), joints({0.2, 0}), 0.01);
    for (int i = 0; i < 5; ++i) arm->step(kServoStep);
  }
  EXPECT_EQ(plain.q(), servoed.q());
  EXPECT_EQ(servoed.q(), servoed.measured().q);
}

}  // namespace
}  // namespace hecaton::planner
