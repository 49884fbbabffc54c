// Invariants of a tick in random situations.
#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/tick.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "services/config/cell_file.hpp"
#include "tests/support/random_situation.hpp"

namespace hecaton::planner {
namespace {

struct TickProperty : ::testing::Test {
  Cell cell = config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/three_puma.yaml").cell;
  CellGeometry geometry = test::geometry_of(cell, 1);
  const LocalParameters& parameters = cell.arms[1].parameters;
  const JointLimits& limits = cell.arms[1].arm.limits;
  TickScratch scratch{geometry};
  Random random{8};
};

TEST_F(TickProperty, VelocityAndAccelerationLimitsAlwaysHold) {
  for (int trial = 0; trial < 20'000; ++trial) {
    test::Situation situation(cell, 1, random);
    TickMemory memory{LocalMemory(random.next())};
    for (int step = 0; step < 3; ++step) {
      const TickInput& input = situation.input;
      const TickResult result = tick(geometry, parameters, input, memory, scratch);
      ASSERT_TRUE(result.q.allFinite() && result.qd.allFinite());
      ASSERT_TRUE((result.qd.cwiseAbs().array() <= limits.velocity.array() + 1e-9).all()) << "trial " << trial;
      ASSERT_TRUE(((result.qd - input.qd).cwiseAbs().array() <= limits.acceleration.array() * input.dt + 1e-9).all())
          << "trial " << trial;
      situation.input.q = result.q;
      situation.input.qd = result.qd;
    }
  }
}

// No command brings a pair nearer than braking does, for any rows.
TEST_F(TickProperty, NoPairApproachesFasterThanItsDamperOrBrakingAllows) {
  ExactDistance distance(geometry);
  Kinematics own;
  std::vector<Kinematics> arms(cell.arms.size());
  std::vector<Clearance> near(kMaxRows);
  int checked = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    test::Situation situation(cell, 1, random);
    for (auto& arm : situation.arms) {
      arm.age = 0.0;
      arm.qd.setZero();
    }
    for (auto& obstacle : situation.obstacles) obstacle.velocity = {};
    const TickInput& input = situation.input;
    TickMemory memory{LocalMemory(random.next())};
    const TickResult result = tick(geometry, parameters, input, memory, scratch);
    const JointVector braking = braking_velocity(limits, input.qd, input.dt);

    const Arm& arm = geometry.own_arm();
    forward_kinematics(*arm.model, arm.X_WB, input.q, own);
    for (std::size_t i = 0; i < arms.size(); ++i) {
      forward_kinematics(*cell.arms[i].arm.model, cell.arms[i].arm.X_WB, situation.arms[i].q, arms[i]);
    }
    const int count = distance.clearances({&own, arms, input.obstacles}, {.others = 0.1, .self = 0.0}, near);
    for (int k = 0; k < count; ++k) {
      JointVector g;
      directional_jacobian(*arm.model, own, near[k].own_link, near[k].p_own_W, near[k].n_W, g);
      const DamperParameters& p = parameters.damper;
      const bool shared = near[k].counterpart == Counterpart::kArm && situation.arms[near[k].other].plans;
      const double xi = (shared ? 0.5 : 1.0) * p.convergence_speed;
      const double allowed =
          xi * (near[k].distance - p.security_distance) / (p.influence_distance - p.security_distance);
      ASSERT_LE(g.dot(result.qd), std::max(allowed, g.dot(braking)) + 1e-6)
          << "trial " << trial << ", " << geometry.own_name(near[k]) << " – " << geometry.other_name(near[k]);
      ++checked;
    }
  }
  EXPECT_GT(checked, 3'000);
}

// Margins depend on measured states alone. They shrink only after the measured speed has fallen, whatever was ordered.
TEST_F(TickProperty, NoMarginDependsOnASpeedOverride) {
  int bound = 0;
  for (int trial = 0; trial < 5'000; ++trial) {
    test::Situation situation(cell, 1, random);
    const TickMemory memory{LocalMemory(random.next())};
    TickMemory at_full_speed = memory;
    const TickResult full = tick(geometry, parameters, situation.input, at_full_speed, scratch);

    situation.input.speed_scaling = random.uniform(0.01, 1.0);
    TickMemory at_low_speed = memory;
    const TickResult slow = tick(geometry, parameters, situation.input, at_low_speed, scratch);
    ASSERT_EQ(slow.rows, full.rows) << "trial " << trial;
    ASSERT_EQ(slow.near, full.near);
    ASSERT_EQ(slow.clearance_margin, full.clearance_margin);
    ASSERT_EQ(slow.clearance_margin_of_moving, full.clearance_margin_of_moving);
    bound += full.rows > 0 ? 1 : 0;

    for (ArmObservation& arm : situation.arms) arm.speed = random.uniform(0.01, 1.0);
    TickMemory beside_slow_arms = memory;
    const TickResult again = tick(geometry, parameters, situation.input, beside_slow_arms, scratch);
    ASSERT_EQ(again.q, slow.q) << "the overrides of other arms change nothing";
    ASSERT_EQ(again.qd, slow.qd);
  }
  EXPECT_GT(bound, 500);
}

TEST_F(TickProperty, SameInputAndMemorySameResult) {
  TickScratch other(geometry);
  for (int trial = 0; trial < 2'000; ++trial) {
    test::Situation situation(cell, 1, random);
    TickMemory memory{LocalMemory(random.next())};
    TickMemory copy = memory;
    for (int step = 0; step < 5; ++step) {
      const TickResult a = tick(geometry, parameters, situation.input, memory, scratch);
      const TickResult b = tick(geometry, parameters, situation.input, copy, other);
      ASSERT_EQ(a.q, b.q);
      ASSERT_EQ(a.qd, b.qd);
      ASSERT_EQ(a.status, b.status);
      situation.input.q = a.q;
      situation.input.qd = a.qd;
    }
  }
}

}  // namespace
}  // namespace hecaton::planner
