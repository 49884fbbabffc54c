// The rows of the damper against hand-derived numbers, on the planar point whose Jacobian is the identity.
#include "planner/local/velocity_damper.hpp"

#include <array>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

TEST(DamperSpeed, IsZeroAtTheSecurityDistanceAndXiAtTheInfluenceDistance) {
  EXPECT_DOUBLE_EQ(damper_speed(0.02, 0.02, 0.12, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(damper_speed(0.12, 0.02, 0.12, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(damper_speed(0.07, 0.02, 0.12, 1.0), 0.5);
  // Inside the security distance it asks for retreat: the corrected sign. As printed (dᵢ, dₛ exchanged) this is +1.2.
  EXPECT_DOUBLE_EQ(damper_speed(0.0, 0.02, 0.12, 1.0), -0.2);
}

struct VelocityDamper : ::testing::Test {
  VelocityDamper() : geometry({test::planar_point("own"), test::planar_point("other")}, 0) {
    forward_kinematics(*geometry.arms()[0].model, Pose::Identity(), joints({0, 0}), own);
    forward_kinematics(*geometry.arms()[1].model, Pose::Identity(), joints({0.2, 0}), arms[1]);
    observations[1] = {joints({0.2, 0}), joints({-0.3, 0.1}), 0.0, true, true};
    obstacles[0].X_WO.translation() = Eigen::Vector3d(0.2, 0, 0);
    obstacles[0].velocity.linear = Eigen::Vector3d(-0.3, 0.1, 0);
    // Two balls of radius 0.05 whose centres are 0.2 apart along x: d = 0.1, n = x.
    clearance.own_link = 2;
    clearance.other_link = 2;
    clearance.distance = 0.1;
    clearance.p_own_W = Eigen::Vector3d(0.05, 0, 0);
    clearance.p_other_W = Eigen::Vector3d(0.15, 0, 0);
    clearance.n_W = Eigen::Vector3d::UnitX();
  }

  Row row(Counterpart counterpart, int other) {
    clearance.counterpart = counterpart;
    clearance.other = other;
    return velocity_damper({geometry, own, arms, observations, obstacles, margins, parameters}, clearance);
  }

  CellGeometry geometry;
  Kinematics own;
  std::array<Kinematics, 2> arms;
  std::array<ArmObservation, 2> observations;
  std::array<world::ObstacleState, 1> obstacles;
  std::array<double, 2> margins{};
  DamperParameters parameters;  // dᵢ 0.12, dₛ 0.02, ξ 1
  Clearance clearance;
};

TEST_F(VelocityDamper, AnObstacleGetsTheWholeXiAndItsVelocityEnters) {
  const Row r = row(Counterpart::kObstacle, 0);
  EXPECT_NEAR((r.g - joints({1, 0})).norm(), 0.0, 1e-12);
  EXPECT_NEAR(r.h, 0.8 - 0.3, 1e-12);  // ξ (0.1 − 0.02)/0.1 + n·v, it comes at 0.3 m/s
  EXPECT_TRUE(r.influences);
}

TEST_F(VelocityDamper, APlannedArmDoesItsHalf) {
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 0.4, 1e-12);  // ξ/2 · 0.8, eq. 8; its velocity does not enter
}

TEST_F(VelocityDamper, AnArmThatDoesNotPlanIsAnObstacle) {
  observations[1].plans = false;
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 0.8 - 0.3, 1e-12);
}

TEST_F(VelocityDamper, OldNewsWidenBothDistances) {
  margins[1] = 0.03;
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 0.5 * (0.1 - 0.05) / 0.1, 1e-12);
  clearance.distance = 0.14;
  EXPECT_TRUE(row(Counterpart::kArm, 1).influences);
}

TEST_F(VelocityDamper, RowsHaveStableDistinctNames) {
  const std::uint32_t arm = row(Counterpart::kArm, 1).key;
  EXPECT_EQ(arm, row(Counterpart::kArm, 1).key);
  EXPECT_NE(arm, row(Counterpart::kObstacle, 0).key);
  clearance.own_body = 1;
  EXPECT_NE(arm, row(Counterpart::kArm, 1).key);
}

}  // namespace
}  // namespace hecaton::planner
