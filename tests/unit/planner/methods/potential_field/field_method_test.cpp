#include "planner/methods/potential_field/field_method.hpp"

#include <gtest/gtest.h>

#include "field_setup.hpp"
#include "planner/arm_controller.hpp"
#include "planner/methods/potential_field/oscillation_monitor.hpp"
#include "planner/methods/registry.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner::potential {
namespace {

using test::ball_obstacle;
using test::box_obstacle;
using test::FieldSetup;
using test::joints;

/// A point on its way; every period's limits and distances are checked.
TickStatus drive(const std::vector<world::Obstacle>& obstacles, const JointVector& from, const JointVector& to,
                 double security_distance = 0.02) {
  const Arm arm = test::planar_point();
  LocalParameters parameters;
  parameters.method = built_in_method("potential_field");
  parameters.damper.security_distance = security_distance;
  parameters.damper.influence_distance = security_distance + 0.1;
  FieldSetup setup(arm, obstacles, PotentialParameters{}, 0.0);
  constexpr double kPeriod = 0.01;
  ArmController controller(CellGeometry({arm}, 0), parameters, kPeriod, 1);
  controller.set_obstacles(obstacles);
  controller.set_goal(to);
  const std::vector<ArmObservation> arms(1);
  MeasuredState state{from, JointVector::Zero(2)};
  TickResult result;
  for (int tick = 0; tick < 3000; ++tick) {
    result = controller.step(state, arms, setup.states, false);
    const JointVector change = (result.qd - state.qd).cwiseAbs();
    EXPECT_TRUE((change.array() <= arm.limits.acceleration.array() * kPeriod + 1e-9).all());
    EXPECT_TRUE((result.qd.cwiseAbs().array() <= arm.limits.velocity.array() + 1e-9).all());
    EXPECT_GT(setup.motion.free_distance(result.q, 1.0), 0.9 * security_distance);
    state = {result.q, result.qd};
    if (result.status == TickStatus::kReached) break;
  }
  return result.status;
}

TEST(FieldVelocity, LeadsALiveArmAroundABall) {
  EXPECT_EQ(drive({ball_obstacle({0, 0.05, 0}, 0.2)}, joints({-1, 0}), joints({1, 0})), TickStatus::kReached);
}

TEST(FieldVelocity, ReachesAGoalBesideAnObstacle) {
  EXPECT_EQ(drive({box_obstacle("wall", {1.2, 0, 0}, {0.1, 0.6, 0.2})}, joints({-1, 0.2}), joints({1.02, 0})),
            TickStatus::kReached);
}

TEST(FieldVelocity, ReportsBlockedInALocalMinimum) {
  EXPECT_EQ(drive({box_obstacle("wall", {0, 0, 0}, {0.1, 0.6, 0.2})}, joints({-1, 0}), joints({1, 0})),
            TickStatus::kBlocked);
}

TEST(FieldVelocity, KeepsTheSecurityDistanceHoweverWeakTheField) {
  EXPECT_EQ(drive({ball_obstacle({0, 0.05, 0}, 0.2)}, joints({-1, 0}), joints({1, 0}), 0.1), TickStatus::kReached);
}

TEST(FieldVelocity, NeverExceedsTheLimits) {
  const Arm arm = test::planar_point();
  FieldSetup setup(arm, {ball_obstacle({0, 0, 0}, 0.2)});
  setup.field.set_goal(joints({2, 1}));
  for (double x = -2.0; x < 2.0; x += 0.03) {
    const JointVector q = joints({x, 0.4});
    const JointVector qd = field_velocity(arm.limits, setup.at(q), q, joints({2, 1}), 0.01);
    EXPECT_TRUE((qd.cwiseAbs().array() <= arm.limits.velocity.array() + 1e-12).all());
    EXPECT_LE(qd.dot(setup.at(q).gradient), 0.0) << "downhill";
  }
}

}  // namespace
namespace {

using test::joints;

TEST(OscillationMonitor, DistinguishesOscillationFromProgress) {
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

TEST(OscillationMonitor, ResetsOnceTheArmMovesAway) {
  OscillationMonitor monitor;
  for (int i = 0; i <= 20; ++i) monitor.observe(joints({i % 2 * 0.1, 0}), 1.0, 20.0, 0.01);
  EXPECT_TRUE(monitor.oscillating);
  for (int i = 0; i <= 20; ++i) monitor.observe(joints({0.1 * i, 0}), 1.0, 20.0, 0.01);
  EXPECT_FALSE(monitor.oscillating);
}

}  // namespace
}  // namespace hecaton::planner::potential
