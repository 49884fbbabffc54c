#include "planner/local/parameters.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

TEST(LocalParameters, DefaultsAreConsistent) {
  EXPECT_EQ(LocalParameters{}.validate(), std::nullopt);
}

TEST(LocalParameters, ErrorsNameKeyValueAndRule) {
  LocalParameters p;
  p.damper.security_distance = 0.12;
  p.damper.influence_distance = 0.10;
  EXPECT_EQ(p.validate(), "damper.security_distance = 0.12 must be below influence_distance = 0.1");
  p = {};
  p.damper.convergence_speed = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(p.validate(), "damper.convergence_speed = nan must be a finite number above 0");
  p = {};
  p.yielding.yield_request_delay = -2.0;
  EXPECT_EQ(p.validate(), "yielding.yield_request_delay = -2 must be 0 (never) or a time in seconds");
}

TEST(Damper, EqualsThePapersLineForShortStops) {
  const Damper damper{.security_distance = 0.02, .width = 0.1, .convergence_speed = 1.0, .response = 0.05};
  EXPECT_DOUBLE_EQ(damper.speed(0.02), 0.0);
  EXPECT_DOUBLE_EQ(damper.speed(0.12), 1.0);
  EXPECT_DOUBLE_EQ(damper.speed(0.07), 0.5);
  EXPECT_DOUBLE_EQ(damper.speed(0.52), 5.0);
  // Inside the security distance it asks for retreat: the corrected sign. As printed (dᵢ, dₛ exchanged) this is +1.2.
  EXPECT_DOUBLE_EQ(damper.speed(0.0), -0.2);
}

TEST(Damper, ShrinksForLinksThatNoPosturePartsFar) {
  const DamperParameters parameters;  // between links dₛ = 10 mm, dᵢ = 110 mm, ξ = 1 m/s
  const Damper damper = parameters.against_self(0.1, 0.016);
  EXPECT_DOUBLE_EQ(damper.security_distance, 0.004);  // a quarter of 16 mm
  EXPECT_DOUBLE_EQ(damper.slope(), parameters.against_self(0.1).slope());
  EXPECT_GT(damper.speed(0.016), 0.0) << "the pair may approach from its widest distance";
  EXPECT_DOUBLE_EQ(parameters.against_self(0.1, 0.04).security_distance, 0.01);  // and no larger than usual
}

TEST(Damper, FlattensBeyondXiForLongStops) {
  const Damper damper{.security_distance = 0.02, .width = 0.1, .convergence_speed = 1.0, .response = 0.25};
  EXPECT_DOUBLE_EQ(damper.speed(0.07), 0.5);  // within dᵢ the line; stops may take S₀ = 0.1 s
  EXPECT_DOUBLE_EQ(damper.time_constant(0.07), 0.1);
  EXPECT_DOUBLE_EQ(damper.speed(0.17), 1.0);  // then ξ; stops may take 0.15 s/1
  EXPECT_DOUBLE_EQ(damper.time_constant(0.17), 0.15);
  EXPECT_DOUBLE_EQ(damper.speed(0.52), 2.0);  // from 0.02 + 0.25 on 1/response
  EXPECT_DOUBLE_EQ(damper.time_constant(0.52), 0.25);
}

}  // namespace
}  // namespace hecaton::planner
