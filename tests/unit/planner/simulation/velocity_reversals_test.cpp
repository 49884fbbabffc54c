#include "planner/simulation/velocity_reversals.hpp"

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

constexpr double kSamplePeriod = 0.01;  // [s]

class ReversalCounterTest : public testing::Test {
 protected:
  /// The limit is 0.5 m/s, so velocities below 0.005 m/s have no sign.
  void add(double x, double y, bool near = true, int periods = 1) {
    for (int k = 0; k < periods; ++k) counter_.add(joints({x, y}), test::planar_point().limits, near, kSamplePeriod);
  }
  ReversalCounter counter_;
};

TEST_F(ReversalCounterTest, SteadyMotionHasNoReversal) {
  add(0.3, -0.2, true, 50);
  EXPECT_EQ(counter_.total().count, 0U);
  EXPECT_NEAR(counter_.total().joint_time, 1.0, 1e-9);  // two joints, half a second
}

TEST_F(ReversalCounterTest, CountsReversalsOfEachJoint) {
  add(0.3, 0.3, true, 20);
  add(-0.3, 0.3, true, 20);   // x reverses
  add(-0.3, -0.3, true, 10);  // y reverses, more than kQuick later
  EXPECT_EQ(counter_.total().count, 2U);
  EXPECT_EQ(counter_.total().quick, 0U);
  EXPECT_NEAR(counter_.total().per_second(), 2.0, 1e-9);  // in 0.5 s of two joints
}

TEST_F(ReversalCounterTest, OscillationIsQuick) {
  for (int k = 0; k < 10; ++k) add(k % 2 == 0 ? 0.1 : -0.1, 0.0);
  EXPECT_EQ(counter_.total().count, 9U);
  EXPECT_EQ(counter_.total().quick, 8U);  // the first reversal follows none
}

TEST_F(ReversalCounterTest, VelocityNearZeroHasNoSign) {
  add(0.1, 0.0);
  add(-0.004, 0.0);
  add(0.1, 0.0);
  EXPECT_EQ(counter_.total().count, 0U);
  add(0.001, 0.0, true, 5);
  add(-0.1, 0.0);
  EXPECT_EQ(counter_.total().count, 1U);
}

TEST_F(ReversalCounterTest, CountsNothingFarFromOtherBodies) {
  add(0.1, 0.0);
  add(-0.1, 0.0, false);
  add(-0.1, 0.0);
  EXPECT_EQ(counter_.total().count, 0U);
  EXPECT_NEAR(counter_.total().joint_time, 2 * 2 * kSamplePeriod, 1e-12);
}

}  // namespace
}  // namespace hecaton::planner
