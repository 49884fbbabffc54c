#include "planner/local/parameters.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

TEST(LocalParameters, DefaultsAreConsistent) {
  EXPECT_EQ(LocalParameters{}.validate(), "");
}

TEST(LocalParameters, RefusalsNameKeyValueAndRule) {
  LocalParameters p;
  p.damper.security_distance = 0.12;
  p.damper.influence_distance = 0.10;
  EXPECT_EQ(p.validate(), "damper.security_distance = 0.12 must be below influence_distance = 0.1");
  p = {};
  p.damper.convergence_speed = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(p.validate(), "damper.convergence_speed = nan must be a finite number above 0");
  p = {};
  p.follower.exit_fraction = 1.0;
  EXPECT_EQ(p.validate(), "follower.exit_fraction = 1 must be between 0 and 1, both excluded");
  p = {};
  p.follower.redraw_after = -1.0;
  EXPECT_EQ(p.validate(), "follower.redraw_after = -1 must be 0 (never) or a time in seconds");
}

TEST(LocalParameters, DistanceOfInvertsTheDamper) {
  const DamperParameters p;
  EXPECT_NEAR(p.distance_of(1.0), p.influence_distance, 1e-12);
  EXPECT_NEAR(p.distance_of(0.0), p.security_distance, 1e-12);
}

}  // namespace
}  // namespace hecaton::planner
