// The rows of the damper against hand-derived numbers, on the planar point whose Jacobian is the identity.
#include "planner/local/velocity_damper.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

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
    return velocity_damper(
        {geometry, own, own_qd, tracking_error, arms, observations, stop_times, obstacles, 0.01, parameters},
        clearance);
  }

  CellGeometry geometry;
  Kinematics own;
  std::array<Kinematics, 2> arms;
  std::array<ArmObservation, 2> observations;
  std::array<world::ObstacleState, 1> obstacles;
  JointVector own_qd = joints({0, 0});
  JointVector tracking_error;
  std::array<double, 2> stop_times{0.05, 0.05};  // [s]
  LocalParameters parameters;                    // dᵢ 0.12, dₛ 0.02, ξ 1: k = 10/s
  Clearance clearance;
};

TEST_F(VelocityDamper, ObstacleRowUsesFullXiAndObstacleVelocity) {
  const Row r = row(Counterpart::kObstacle, 0);
  EXPECT_NEAR((r.g - joints({1, 0})).norm(), 0.0, 1e-12);
  EXPECT_NEAR(r.h, 0.8 - 0.3, 1e-12);  // ξ (0.1 − 0.02)/0.1 + n·v, it comes at 0.3 m/s
  EXPECT_TRUE(r.influences);
}

TEST_F(VelocityDamper, PlannedArmRowUsesHalfXi) {
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 0.4, 1e-12);  // ξ/2 · 0.8, eq. 8; its velocity does not enter
}

TEST_F(VelocityDamper, UnplannedArmCountsAsAnObstacle) {
  observations[1].plans = false;
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 0.8 - 0.3, 1e-12);
}

// It keeps no damper: after 0.2 s of its 4 m/s² it may be 0.08 m nearer, all that remained before dₛ.
TEST_F(VelocityDamper, ArmThatOthersMoveMayUseItsWholeAcceleration) {
  observations[1].plans = false;
  observations[1].foreign = true;
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 0.8 - 0.3, 1e-12);
  observations[1].qd.setZero();
  observations[1].age = 0.2;
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 0.0, 1e-12);
}

TEST_F(VelocityDamper, OldArmStateUsesLeastDistance) {
  // The arm was at rest 0.2 s ago and may have approached with k/2 x since: 0.08 e^(−1) remain before dₛ. The bound
  // from 4 m/s² alone would be smaller.
  observations[1].qd.setZero();
  observations[1].age = 0.2;
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 5.0 * 0.08 * std::exp(-1.0), 1e-12);
  // The arm approached at 0.3 m/s: it was 0.08 + 0.06 before dₛ.
  observations[1].qd = joints({-0.3, 0.1});
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 5.0 * 0.14 * std::exp(-1.0), 1e-12);
  // After 10 ms acceleration is the tighter bound: ½·4·0.01² = 0.0002.
  observations[1].age = 0.01;
  observations[1].qd.setZero();
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 5.0 * (0.08 - 0.0002), 1e-12);
}

TEST_F(VelocityDamper, OldObstacleStateAddsAccelerationMargin) {
  obstacles[0].age = 0.1;
  parameters.acceleration_of_obstacles = 2.0;
  EXPECT_NEAR(row(Counterpart::kObstacle, 0).h, 10.0 * (0.08 - 0.01) - 0.3, 1e-12);
}

TEST_F(VelocityDamper, LongStopTimesAreAllowedOnlyFarAway) {
  stop_times = {0.19, 0.24};
  EXPECT_NEAR(row(Counterpart::kObstacle, 0).stop_time, 0.1 - 0.01, 1e-12);  // within dᵢ
  clearance.distance = 0.62;
  EXPECT_NEAR(row(Counterpart::kObstacle, 0).h, 0.6 / 0.2 - 0.3, 1e-12);
  EXPECT_NEAR(row(Counterpart::kArm, 1).h, 0.5 * 0.6 / 0.25, 1e-12);  // the slower of both
  EXPECT_NEAR(row(Counterpart::kArm, 1).stop_time, 0.24, 1e-12);
}

TEST_F(VelocityDamper, TrackingErrorReducesTheDistance) {
  tracking_error = joints({0.01, 0.05});
  EXPECT_NEAR(row(Counterpart::kObstacle, 0).h, 0.7 - 0.3, 1e-12);
  tracking_error = joints({-0.01, 0.05});  // farther away: the reference counts
  EXPECT_NEAR(row(Counterpart::kObstacle, 0).h, 0.8 - 0.3, 1e-12);
}

TEST_F(VelocityDamper, RowKeysAreStableAndDistinct) {
  const std::uint32_t arm = row(Counterpart::kArm, 1).key;
  EXPECT_EQ(arm, row(Counterpart::kArm, 1).key);
  EXPECT_NE(arm, row(Counterpart::kObstacle, 0).key);
  clearance.own_body = 1;
  EXPECT_NE(arm, row(Counterpart::kArm, 1).key);
}

}  // namespace
}  // namespace hecaton::planner
