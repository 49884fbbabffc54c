#include "planner/local/right_of_way.hpp"

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;
using test::kPeriod;

/// Arm 1 of three; arm 0 is near it.
class RightOfWayTest : public testing::Test {
 protected:
  RightOfWayTest() : arms_(3) {
    for (ArmObservation& arm : arms_) {
      arm.known = arm.plans = arm.has_goal = true;
      arm.q = arm.qd = arm.q_goal = joints({0.0, 0.0});
    }
    Row row;
    row.g = joints({1.0, 0.0});  // arm 0 is on the right
    row.h = 0.0;
    row.arm = 0;
    row.influences = true;
    rows_.push_back(row);
    right_.under_way = true;
  }

  [[nodiscard]] RightOfWayInput input(bool blocked = false, double distance = 1.0) const {
    return {parameters_, arms_, 1, rows_, kPeriod, blocked, distance};
  }
  void pass(double seconds, bool blocked, double distance = 1.0) {
    for (double t = 0.0; t < seconds; t += kPeriod) update(input(blocked, distance), random_, right_);
  }

  LocalParameters parameters_;
  std::vector<ArmObservation> arms_;
  std::vector<Row> rows_;
  Random random_{5};
  RightOfWay right_;
};

TEST(Priorities, AreATotalOrder) {
  Random random(1);
  const auto draw = [&random] {
    return Priority{static_cast<std::uint32_t>(random.next() % 4), int(random.next() % 4)};
  };
  for (int trial = 0; trial < 10'000; ++trial) {
    const Priority a = draw();
    const Priority b = draw();
    const Priority c = draw();
    const bool same = a.number == b.number && a.arm == b.arm;
    EXPECT_EQ(int(a.precedes(b)) + int(b.precedes(a)), same ? 0 : 1);
    EXPECT_TRUE(!a.precedes(b) || !b.precedes(c) || a.precedes(c));
  }
}

TEST_F(RightOfWayTest, NoArmYieldsWithoutARequest) {
  pass(5.0, false);
  EXPECT_EQ(right_.yields_to, -1);
  EXPECT_EQ(right_.priority, 0U);
}

TEST_F(RightOfWayTest, BlockedArmRequestsAfterItsDelay) {
  pass(0.7 * parameters_.yielding.yield_request_delay, true);
  EXPECT_EQ(right_.priority, 0U);
  pass(0.6 * parameters_.yielding.yield_request_delay, true);
  EXPECT_EQ(right_.priority, 1U);
  EXPECT_TRUE(right_.leads);
}

TEST_F(RightOfWayTest, DelayGrowsWithEachRequest) {
  pass(1.3 * parameters_.yielding.yield_request_delay, true);
  EXPECT_EQ(right_.priority, 1U);
  arms_[0].priority = 2;  // asks back
  pass(0.9 * parameters_.yielding.yield_request_delay, true);
  EXPECT_EQ(right_.priority, 1U) << "a quarter less than 1.25 times the delay";
  pass(0.8 * parameters_.yielding.yield_request_delay, true);
  EXPECT_EQ(right_.priority, 3U);
}

TEST_F(RightOfWayTest, FreeMotionNearerToTheGoalResetsTheDelay) {
  for (double distance = 1.0; distance > 0.5; distance -= 0.1) {
    pass(0.7 * parameters_.yielding.yield_request_delay, true, distance);
    pass(1.0, false, distance - 0.05);
  }
  EXPECT_EQ(right_.priority, 0U);
}

// An arm that circles one at rest comes no nearer to its goal, however free its way is on the far side.
TEST_F(RightOfWayTest, FreeMotionFartherFromTheGoalDoesNot) {
  pass(0.7 * parameters_.yielding.yield_request_delay, true, 1.0);
  pass(1.0, false, 1.2);
  EXPECT_EQ(right_.priority, 0U);
  pass(0.6 * parameters_.yielding.yield_request_delay, true, 1.0);
  EXPECT_EQ(right_.priority, 1U);
}

TEST_F(RightOfWayTest, YieldsToANearArmAndThenRequestsItself) {
  arms_[0].priority = 1;
  pass(0.1, false);
  EXPECT_EQ(right_.yields_to, 0);
  EXPECT_FALSE(right_.leads);
  pass(1.3 * parameters_.yielding.yield_request_delay, false);
  EXPECT_EQ(right_.priority, 2U);
  EXPECT_EQ(right_.yields_to, -1);
}

TEST_F(RightOfWayTest, EachNewPriorityRestartsTheDelay) {
  for (std::uint32_t priority = 1; priority <= 5; ++priority) {
    arms_[0].priority = priority;
    pass(0.7 * parameters_.yielding.yield_request_delay, false);
    EXPECT_EQ(right_.yields_to, 0);
  }
  EXPECT_EQ(right_.priority, 0U);
}

TEST_F(RightOfWayTest, DoesNotYieldToADistantArm) {
  arms_[2].priority = 1;
  pass(0.1, false);
  EXPECT_EQ(right_.yields_to, -1);
}

TEST_F(RightOfWayTest, ContinuesSoonAfterTheOtherArmHasPassed) {
  arms_[0].priority = 1;
  pass(0.1, false);
  rows_.clear();
  pass(0.2, false);
  EXPECT_EQ(right_.yields_to, 0);
  pass(0.2, false);
  EXPECT_EQ(right_.yields_to, -1);
}

TEST_F(RightOfWayTest, DoesNotYieldToAnArrivedOrUnplannedArm) {
  arms_[0].priority = 1;
  arms_[0].has_goal = false;
  pass(0.1, false);
  EXPECT_EQ(right_.yields_to, -1);
  arms_[0].has_goal = true;
  arms_[0].plans = false;
  pass(0.1, false);
  EXPECT_EQ(right_.yields_to, -1);
}

TEST_F(RightOfWayTest, RestingArmYieldsUnlessConfiguredOtherwise) {
  right_.under_way = false;
  right_.priority = 7;  // of an earlier goal
  arms_[0].priority = 1;
  pass(0.1, false);
  EXPECT_EQ(right_.yields_to, 0);
  pass(10.0, false);
  EXPECT_EQ(right_.priority, 7U) << "it has no business to ask";
  parameters_.yielding.at_rest = false;
  pass(0.1, false);
  EXPECT_EQ(right_.yields_to, -1);
}

TEST_F(RightOfWayTest, ZeroDelayDisablesRequestsAndYielding) {
  parameters_.yielding.yield_request_delay = 0.0;
  arms_[0].priority = 1;
  pass(10.0, true);
  EXPECT_EQ(right_.yields_to, -1);
  EXPECT_EQ(right_.priority, 0U);
}

// h = 0 at dₛ: as fast as the limits allow, straight away; h = ½ ξ at dᵢ: at rest.
TEST_F(RightOfWayTest, RetreatsFasterFromNearerArms) {
  arms_[0].priority = 1;
  const JointLimits limits = test::planar_point().limits;
  EXPECT_EQ(retreat_velocity(input(), right_, limits), joints({-0.5, 0.0}));
  rows_[0].h = 0.25 * parameters_.damper.convergence_speed;
  EXPECT_EQ(retreat_velocity(input(), right_, limits), joints({-0.25, 0.0}));
  rows_[0].h = 0.5 * parameters_.damper.convergence_speed;
  EXPECT_EQ(retreat_velocity(input(), right_, limits), joints({0.0, 0.0}));
}

}  // namespace
}  // namespace hecaton::planner
