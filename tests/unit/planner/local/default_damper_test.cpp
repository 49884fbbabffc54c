// Default damper parameters by hand.
#include "planner/local/default_damper.hpp"

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

/// Reach 1 m, stops of 0.25 s and a period of 10 ms: braking keeps ξ = 0.1 m/0.26 s.
constexpr DamperBasis kArm{1.0, 0.25, 0.01, 0.02};

TEST(DefaultDamper, FollowsFromReachAndBraking) {
  const DamperParameters damper = default_damper(kArm);
  EXPECT_DOUBLE_EQ(damper.security_distance, 0.02);
  EXPECT_DOUBLE_EQ(damper.self_security_distance, 0.01);
  EXPECT_DOUBLE_EQ(damper.convergence_speed, 0.384);
  EXPECT_DOUBLE_EQ(damper.influence_distance, 0.12);
  EXPECT_DOUBLE_EQ(damper.self_influence_distance, 0.11);
}

TEST(DefaultDamper, GivesSlowArmsWiderDampers) {
  // Stops of 1.5 s: 0.25 m/s · 1.51 s = 0.3775 m.
  const DamperParameters damper = default_damper({1.0, 1.5, 0.01, 0.02});
  EXPECT_DOUBLE_EQ(damper.convergence_speed, 0.25);
  EXPECT_DOUBLE_EQ(damper.influence_distance, 0.398);
}

TEST(DefaultDamper, KeepsWhatIsGiven) {
  GivenDamper given;
  given.influence_distance = 0.08;
  given.convergence_speed = 0.9;
  given.self_security_distance = 0.003;
  const DamperParameters damper = default_damper(kArm, given);
  EXPECT_DOUBLE_EQ(damper.influence_distance, 0.08);
  EXPECT_DOUBLE_EQ(damper.convergence_speed, 0.9);
  EXPECT_DOUBLE_EQ(damper.self_security_distance, 0.003);
  EXPECT_DOUBLE_EQ(damper.self_influence_distance, 0.237);  // 0.003 + 0.9 · 0.26
}

TEST(DefaultDamper, SlowsDownForAGivenInfluenceDistance) {
  GivenDamper given;
  given.influence_distance = 0.04;
  const DamperParameters damper = default_damper(kArm, given);
  EXPECT_DOUBLE_EQ(damper.security_distance, 0.01);
  EXPECT_DOUBLE_EQ(damper.convergence_speed, 0.115);  // 0.03/0.26 = 0.1154
}

// For any arm: braking can keep the damper, and the security distance covers the latency (validate() warns otherwise).
TEST(DefaultDamper, CanBeKeptByBraking) {
  for (const double reach : {0.05, 0.3, 0.7, 1.3, 2.0, 30.0}) {
    for (const double stop : {0.01, 0.1, 0.25, 0.6, 2.0}) {
      for (const double latency : {0.004, 0.02, 0.2}) {
        const DamperBasis basis{reach, stop, 0.01, latency};
        const DamperParameters damper = default_damper(basis);
        const double response = stop + basis.control_period;
        EXPECT_LE(damper.against_others(response).slope(), (1.0 + 1e-9) / response);
        EXPECT_LE(damper.against_self(response).slope(), (1.0 + 1e-9) / response);
        EXPECT_GE(damper.security_distance, damper.convergence_speed * latency - 1e-12);
        LocalParameters parameters;
        parameters.damper = damper;
        EXPECT_EQ(parameters.validate(), std::nullopt);
      }
    }
  }
}

}  // namespace
}  // namespace hecaton::planner
