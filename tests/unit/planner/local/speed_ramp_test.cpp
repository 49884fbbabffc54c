#include "planner/local/speed_ramp.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/methods/registry.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;
using test::kPeriod;
const JointLimits kRampLimits = test::planar_point().limits;

TEST(SpeedRamp, ChangesTheVelocityLimitsByHalfTheAccelerationAtMost) {
  SpeedRamp ramp(kRampLimits);
  EXPECT_DOUBLE_EQ((ramp.rate() * kRampLimits.velocity.array() / kRampLimits.acceleration.array()).maxCoeff(), 0.5);
  double before = ramp.share();
  int periods = 0;
  for (; ramp.share() > 0.01; ++periods) {
    ramp.advance(0.01, before * kRampLimits.velocity, kPeriod);
    ASSERT_LE(before - ramp.share(), ramp.rate() * kPeriod + 1e-12);
    before = ramp.share();
  }
  EXPECT_LE(periods * kPeriod, 2.0 * longest_stop_time(kRampLimits) + kPeriod);
  for (; ramp.share() < 1.0; before = ramp.share()) {
    ramp.advance(1.0, before * kRampLimits.velocity, kPeriod);
    ASSERT_LE(ramp.share() - before, ramp.rate() * kPeriod + 1e-12);
  }
}

TEST(SpeedRamp, BeginsAtTheOrderForAnArmThatStands) {
  SpeedRamp ramp(kRampLimits);
  ramp.advance(0.3, joints({0, 0}), kPeriod);
  EXPECT_DOUBLE_EQ(ramp.share(), 0.3);
}

TEST(SpeedRamp, NeverExceedsTheMotionAtATakeover) {
  SpeedRamp ramp(kRampLimits);
  ramp.advance(0.1, 0.5 * kRampLimits.velocity, kPeriod);
  EXPECT_LT(ramp.share(), 0.5);
  EXPECT_GE(ramp.share(), 0.5 - ramp.rate() * kPeriod);
}

class SpeedOverride : public ::testing::Test {
 protected:
  SpeedOverride() {
    LocalParameters parameters;
    parameters.method = built_in_method("local");
    controller_.emplace(CellGeometry({test::planar_point()}, 0), parameters, kPeriod, 1);
  }
  /// One period of a drive that follows exactly.
  TickResult step() {
    const TickResult result = controller_->step(at_, no_arms_, {}, false);
    const JointVector acceleration = (result.qd - at_.qd).cwiseAbs() / kPeriod;
    most_acceleration_ = std::max(most_acceleration_, acceleration.cwiseQuotient(kRampLimits.acceleration).maxCoeff());
    at_ = {result.q, result.qd};
    return result;
  }
  [[nodiscard]] double share() const { return at_.qd.cwiseAbs().cwiseQuotient(kRampLimits.velocity).maxCoeff(); }

  std::optional<ArmController> controller_;
  std::array<ArmObservation, 1> no_arms_{};
  MeasuredState at_{joints({-1, 0}), joints({0, 0})};
  double most_acceleration_ = 0.0;  ///< relative to the limits
};

TEST_F(SpeedOverride, SlowsAnArmUnderWayWithoutEndingItsGoal) {
  controller_->set_goal(joints({1, 0.5}));
  for (int k = 0; k < 100; ++k) step();
  EXPECT_GT(share(), 0.95);
  controller_->order_speed(0.3);
  for (int k = 0; k < 30; ++k) step();
  EXPECT_NEAR(share(), 0.3, 1e-6) << "after twice the stop time of 0.125 s";
  TickResult result;
  for (int k = 0; k < 3000 && result.status != TickStatus::kReached; ++k) {
    result = step();
    ASSERT_LE(share(), 0.3 + 1e-9);
  }
  EXPECT_EQ(result.status, TickStatus::kReached);
  EXPECT_LE(most_acceleration_, 1.0 + 1e-9);
}

TEST_F(SpeedOverride, NeverExceedsAccelerationsUnderRandomOrders) {
  Random random(3);
  double highest = 0.0;
  for (int k = 0; k < 20'000; ++k) {
    if (random.uniform() < 0.05) controller_->order_speed(random.uniform(0.01, 1.0));
    if (random.uniform() < 0.02) controller_->set_goal(joints({random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)}));
    step();
    ASSERT_LE(share(), controller_->speed() + 1e-9) << "period " << k;
    highest = std::max(highest, share());
  }
  EXPECT_LE(most_acceleration_, 1.0 + 1e-9);
  EXPECT_GT(highest, 0.9);
}

TEST_F(SpeedOverride, MovesFirstAtTheOrder) {
  controller_->order_speed(0.05);
  controller_->set_goal(joints({1, 0}));
  for (int k = 0; k < 200; ++k) {
    step();
    ASSERT_LE(share(), 0.05 + 1e-9);
  }
  EXPECT_NEAR(share(), 0.05, 1e-6);
}

TEST_F(SpeedOverride, CombinesWithTheDeviceByTheLowerOne) {
  controller_->set_goal(joints({1, 0}));
  for (const auto& [ordered, device, expected] :
       {std::array{0.2, 0.5, 0.2}, std::array{0.5, 0.2, 0.2}, std::array{1.0, 0.4, 0.4}}) {
    controller_->order_speed(ordered);
    for (int k = 0; k < 60; ++k) {
      OwnArmFeedback feedback;
      feedback.state = at_;
      feedback.follows = true;
      feedback.speed_scaling = device;
      const TickResult result = controller_->step(feedback, no_arms_, {}, false);
      at_ = {result.q, result.qd};
    }
    EXPECT_NEAR(controller_->speed(), expected, 1e-9);
  }
}

TEST_F(SpeedOverride, CountsProgressOfASlowArmSlowly) {
  controller_->order_speed(0.01);
  controller_->set_goal(joints({2, 0}));
  // 3 m at 5 mm/s: 2 % of the distance take 12 s, more than the 10 s of an arm at full speed.
  for (int k = 0; k < 6000; ++k) {
    const TickResult result = step();
    ASSERT_EQ(result.status, TickStatus::kMoving) << "period " << k;
    ASSERT_LT(controller_->goal_progress().time_without_progress(), 0.5);
  }
  EXPECT_NEAR(at_.q[0], -1.0 + 60.0 * 0.005, 0.01);
}

}  // namespace
}  // namespace hecaton::planner
