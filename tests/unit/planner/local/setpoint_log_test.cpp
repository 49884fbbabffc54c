#include "planner/setpoint_log.hpp"

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

const JointLimits kLimits{joints({-3, -3}), joints({3, 3}), joints({0.5, 0.5}), joints({4, 4})};

class SetpointLogTest : public testing::Test {
 protected:
  SetpointLogTest() { log_.sent(7, {joints({1, 0}), joints({0.4, -0.2})}); }

  JointVector reference(double age) { return log_.reference(7, age).value().q; }

  SetpointLog log_{kLimits, 0.01};
};

TEST_F(SetpointLogTest, UntilASetPointIsDueTheDriveIsOnItsWayThere) {
  EXPECT_NEAR((reference(0.0) - joints({0.996, 0.002})).norm(), 0.0, 1e-12);
  EXPECT_EQ(reference(0.01), joints({1, 0}));
}

TEST_F(SetpointLogTest, ThenItIsOnTheStopFromIt) {
  // T = 0.4/4 = 0.1 s: 0.05 s later 0.4 · (0.05 − 0.0125) on, after T at rest 0.4 · 0.05 on.
  EXPECT_NEAR((reference(0.06) - joints({1.015, -0.0075})).norm(), 0.0, 1e-12);
  EXPECT_NEAR((reference(1.0) - joints({1.02, -0.01})).norm(), 0.0, 1e-12);
  EXPECT_EQ(log_.reference(7, 1.0).value().qd, joints({0, 0}));
}

TEST_F(SetpointLogTest, KnowsOnlyWhatWasSentOfLate) {
  EXPECT_FALSE(log_.reference(0, 0.0));
  EXPECT_FALSE(log_.reference(6, 0.0));
  EXPECT_FALSE(log_.reference(7 + 64, 0.0));
  log_.sent(7 + 64, {joints({2, 0}), joints({0, 0})});
  EXPECT_FALSE(log_.reference(7, 0.0)) << "64 set-points ago";
}

}  // namespace
}  // namespace hecaton::planner
