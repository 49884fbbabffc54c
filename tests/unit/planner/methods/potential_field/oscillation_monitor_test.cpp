#include "planner/methods/potential_field/oscillation_monitor.hpp"

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner::potential {
namespace {

using test::joints;

TEST(OscillationMonitor, TellsToAndFroFromProgress) {
  OscillationMonitor forward, to_and_fro, still;
  for (int i = 0; i < 25; ++i) {
    forward.observe(joints({0.01 * i, 0}), 1.0, 20.0, 0.01);
    to_and_fro.observe(joints({0.0, i % 2 == 0 ? 0.01 : -0.01}), 1.0, 20.0, 0.01);
    still.observe(joints({0, 0}), 1.0, 20.0, 0.01);
  }
  EXPECT_FALSE(forward.oscillating);
  EXPECT_TRUE(to_and_fro.oscillating);
  EXPECT_FALSE(still.oscillating) << "an arm at rest does not oscillate";
}

TEST(OscillationMonitor, ForgetsOnceTheArmGetsAway) {
  OscillationMonitor monitor;
  for (int i = 0; i <= 20; ++i) monitor.observe(joints({i % 2 * 0.1, 0}), 1.0, 20.0, 0.01);
  EXPECT_TRUE(monitor.oscillating);
  for (int i = 0; i <= 20; ++i) monitor.observe(joints({0.1 * i, 0}), 1.0, 20.0, 0.01);
  EXPECT_FALSE(monitor.oscillating);
}

}  // namespace
}  // namespace hecaton::planner::potential
