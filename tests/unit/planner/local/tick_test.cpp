// The whole tick on the planar point: figure 11 of [Lahouar06], and the contract of tick().
#include "planner/tick.hpp"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/unit/planner/local/journey.hpp"

namespace hecaton::planner {
namespace {

using test::box_obstacle;
using test::joints;

TEST(Tick, ReachesAFreeGoalStraightAndFast) {
  Journey run({}, built_in_method("local"));
  ASSERT_EQ(run.drive(joints({-1, 0}), joints({1, 0}), 1000), TickStatus::kReached);
  // 2 m at 0.5 m/s, plus ramps of 0.125 s and the exponential end: no less than 4 s, no more than 5.
  EXPECT_GT(run.ticks, 400);
  EXPECT_LT(run.ticks, 500);
}

TEST(Tick, MovesAtTheShareOfSpeedThatTheDeviceExecutes) {
  Journey run({}, built_in_method("local"));
  run.input.speed_scaling = 0.2;
  ASSERT_EQ(run.drive(joints({-1, 0}), joints({1, 0}), 5000), TickStatus::kReached);
  EXPECT_GT(run.ticks, 2000) << "2 m at 0.1 m/s";
  EXPECT_LT(run.ticks, 2500);
}

TEST(Tick, ContinuousJointTakesTheShorterDirection) {
  Arm arm = test::planar_point();
  arm.limits.upper[0] = std::numeric_limits<double>::infinity();
  arm.limits.lower[0] = -arm.limits.upper[0];
  const CellGeometry geometry({arm}, 0);
  TickScratch scratch(geometry);
  TickMemory memory{LocalMemory(1)};
  const std::array<ArmObservation, 1> no_arms;
  TickInput input;
  input.q = joints({3.1, 0});
  input.qd = joints({0, 0});
  input.q_goal = joints({-3.1, 0});
  input.has_goal = true;
  input.arms = no_arms;
  TickResult result;
  for (int k = 0; k < 300 && result.status != TickStatus::kReached; ++k) {
    result = tick(geometry, {}, input, memory, scratch);
    input.q = result.q;
    input.qd = result.qd;
  }
  EXPECT_EQ(result.status, TickStatus::kReached);
  EXPECT_NEAR(input.q[0], 2.0 * 3.14159265358979 - 3.1, 1e-2) << "not back by six radians";
}

TEST(Tick, ConstraintsAloneStopBeforeAWall) {
  Journey run(kWall, built_in_method("local"));
  EXPECT_EQ(run.drive(joints({-1, 0}), joints({1, 0}), 3000), TickStatus::kBlocked);
  EXPECT_GE(run.nearest, 0.019);  // dₛ
}

TEST(Tick, BoundaryFollowingGoesAroundTheWall) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Journey run(kWall, built_in_method("boundary_following"), seed);
    EXPECT_EQ(run.drive(joints({-1, 0}), joints({1, 0}), 6000), TickStatus::kReached) << "seed " << seed;
    EXPECT_GE(run.nearest, 0.019);
  }
}

TEST(Tick, BoundaryFollowingSwitchesWallsInACorner) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Journey run(kCorner, built_in_method("boundary_following"), seed);
    EXPECT_EQ(run.drive(joints({-1, 0.1}), joints({1.5, 0.1}), 12000), TickStatus::kReached) << "seed " << seed;
    EXPECT_GE(run.nearest, 0.019);
  }
}

// Another arm has pushed it behind the wall, around which it would find a way.
TEST(Tick, ArmPushedAwayFromAReachedGoalReturnsStraightAsFarAsThereIsRoom) {
  Journey run(kWall, built_in_method("boundary_following"));
  ASSERT_EQ(run.drive(joints({0.5, 0}), joints({1, 0}), 1000), TickStatus::kReached);
  run.input.q = joints({-1, 0});
  run.input.qd = joints({0, 0});
  for (int k = 0; k < 1000; ++k) {
    const TickResult result = run.step();
    ASSERT_NE(result.status, TickStatus::kFollowingBoundary) << k;
    ASSERT_FALSE(result.awaiting_rollout) << k;
    ASSERT_EQ(run.input.q[1], 0.0) << k;
  }
  EXPECT_EQ(run.input.qd, joints({0, 0}));
  EXPECT_GT(run.input.q[0], -0.3) << "it has come near the wall";
  EXPECT_GE(run.nearest, 0.019);

  run.input.q = joints({0.5, 0.3});
  for (int k = 0; k < 1000; ++k) run.step();
  EXPECT_LT((run.input.q - run.input.q_goal).norm(), 3e-3) << "with room";
}

/// Moves to the wall until the arm would deviate but waits for a rollout, for up to 0.1 s.
void drive_until_awaiting_rollout(Journey& run) {
  run.input.q = joints({-1, 0});
  run.input.q_goal = joints({1, 0});
  for (int k = 0; k < 1000; ++k) {
    run.memory.local.rollout_wait = 0.1;
    const TickResult result = run.step();
    ASSERT_NE(result.status, TickStatus::kFollowingBoundary);
    if (result.awaiting_rollout) return;
  }
  FAIL() << "the wall never blocked it";
}

TEST(Tick, BlockedArmWaitsForARolloutNoLongerThanAllowed) {
  Journey run(kWall, built_in_method("boundary_following"));
  drive_until_awaiting_rollout(run);
  int waited = 1;
  while (run.step().awaiting_rollout) ++waited;
  EXPECT_NEAR(waited, 10, 1);  // 0.1 s of 10 ms
  EXPECT_TRUE(run.memory.local.deviation.active);
}

TEST(Tick, BlockedArmDeviatesOnceTheRolloutSaysContinue) {
  Journey run(kWall, built_in_method("boundary_following"));
  drive_until_awaiting_rollout(run);
  begin({}, run.memory.local);
  EXPECT_EQ(run.step().status, TickStatus::kFollowingBoundary);
}

TEST(Tick, ReportsTheBindingPair) {
  Journey run(kWall, built_in_method("local"));
  run.drive(joints({-1, 0}), joints({1, 0}), 2000);
  const TickResult result = run.step();
  ASSERT_TRUE(result.has_binding);
  EXPECT_EQ(run.geometry.own_name(result.binding), "point/ball");
  EXPECT_EQ(run.geometry.other_name(result.binding), "wall");
  EXPECT_NEAR(result.binding.distance, 0.02, 1e-3);
}

TEST(Tick, ReportsTheFollowedBoundary) {
  Journey run(kWall, built_in_method("boundary_following"));
  run.input.q = joints({-1, 0});
  run.input.q_goal = joints({1, 0});
  int following = 0;
  for (int k = 0; k < 6000; ++k) {
    const TickResult result = run.step();
    if (result.status == TickStatus::kReached) break;
    if (result.status != TickStatus::kFollowingBoundary) continue;
    ++following;
    ASSERT_TRUE(result.has_binding) << "period " << k;
    EXPECT_EQ(run.geometry.other_name(result.binding), "wall");
  }
  EXPECT_GT(following, 10);
}

TEST(Tick, IsAFunctionOfInputAndMemory) {
  Journey first(kCorner, built_in_method("boundary_following"), 5);
  Journey second(kCorner, built_in_method("boundary_following"), 5);
  first.drive(joints({-1, 0.1}), joints({1.5, 0.1}), 777);
  second.drive(joints({-1, 0.1}), joints({1.5, 0.1}), 777);
  EXPECT_EQ(first.input.q, second.input.q);
  TickScratch fresh(first.geometry);
  TickMemory copy = first.memory;
  const TickResult a = tick(first.geometry, first.parameters, first.input, copy, fresh);
  const TickResult b = first.step();
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.qd, b.qd);
}

TEST(Tick, BrakesOnTheStopProfileWhenHeld) {
  Journey run({}, built_in_method("local"));
  run.drive(joints({-1, 0}), joints({1, 0}), 100);
  run.input.hold = true;
  const double before = run.input.qd[0];
  EXPECT_EQ(run.step().status, TickStatus::kHolding);
  EXPECT_NEAR(run.input.qd[0], before - 0.04, 1e-12);  // 4 m/s² for 10 ms
}

TEST(Tick, BrakesWhenAnArmStateIsUnknownOrTooOld) {
  CellGeometry geometry({test::planar_point("own"), test::planar_point("other")}, 0);
  TickScratch scratch(geometry);
  TickMemory memory;
  std::array<ArmObservation, 2> arms;
  TickInput input;
  input.q = joints({0, 0});
  input.qd = joints({0.4, 0});
  input.q_goal = joints({1, 0});
  input.has_goal = true;
  input.arms = arms;
  LocalParameters parameters;
  TickResult result = tick(geometry, parameters, input, memory, scratch);
  EXPECT_EQ(result.status, TickStatus::kStaleInput);
  EXPECT_EQ(result.stale_arm, 1);
  EXPECT_NEAR(result.qd[0], 0.36, 1e-12);
  arms[1] = {joints({2, 0}), joints({0, 0}), 0.05, true, true};
  EXPECT_EQ(tick(geometry, parameters, input, memory, scratch).status, TickStatus::kMoving);
  arms[1].age = 0.3;  // the limit is 0.25
  EXPECT_EQ(tick(geometry, parameters, input, memory, scratch).status, TickStatus::kStaleInput);
}

// Two points that exchange places head-on: neither can go straight, both give way, and no contact occurs.
TEST(Tick, TwoArmsExchangePlaces) {
  std::vector<Arm> cell{test::planar_point("a"), test::planar_point("b")};
  std::array<CellGeometry, 2> geometry{CellGeometry(cell, 0), CellGeometry(cell, 1)};
  std::array<TickScratch, 2> scratch{TickScratch(geometry[0]), TickScratch(geometry[1])};
  std::array<TickMemory, 2> memory{TickMemory{LocalMemory(3)}, TickMemory{LocalMemory(4)}};
  std::array<ArmObservation, 2> arms{ArmObservation{joints({-1, 0}), joints({0, 0}), 0, true, true},
                                     ArmObservation{joints({1, 0}), joints({0, 0}), 0, true, true}};
  const std::array<JointVector, 2> goals{joints({1, 0}), joints({-1, 0})};
  bool reached = false;
  double nearest = 10.0;
  for (int step = 0; step < 6000 && !reached; ++step) {
    std::array<TickResult, 2> results;
    for (int i = 0; i < 2; ++i) {
      TickInput input;
      input.q = arms[i].q;
      input.qd = arms[i].qd;
      input.q_goal = goals[i];
      input.has_goal = true;
      input.arms = arms;
      results[i] = tick(geometry[i], LocalParameters{}, input, memory[i], scratch[i]);
    }
    for (int i = 0; i < 2; ++i) {
      arms[i].q = results[i].q;
      arms[i].qd = results[i].qd;
    }
    nearest = std::min(nearest, (arms[0].q - arms[1].q).norm() - 0.1);
    reached = results[0].status == TickStatus::kReached && results[1].status == TickStatus::kReached;
  }
  EXPECT_TRUE(reached);
  EXPECT_GT(nearest, 0.015);
}

// Manoeuvres change only the memory; the same dampers, limits and rows hold.
TEST(Tick, ReportsItsClearanceMargin) {
  Journey alone({}, built_in_method("boundary_following"));
  alone.input.q = joints({0, 0});
  alone.input.has_goal = false;
  EXPECT_TRUE(std::isinf(alone.step().clearance_margin));
  Journey journey({box_obstacle("box", {0, 0.25, 0}, {0.1, 0.1, 0.1})}, built_in_method("boundary_following"));
  journey.input.q = joints({0, 0});
  journey.input.has_goal = false;
  EXPECT_NEAR(journey.step().clearance_margin, 0.1 - journey.parameters.damper.security_distance,
              1e-9);  // 0.25 − 0.1 − 0.05
}

/// The point among one other arm that was lost: it rests within 0.2 m of (0, 0) along both axes, so nearer than 0.4 m.
struct BesideALostArm {
  BesideALostArm() : geometry({test::planar_point("own"), test::planar_point("lost")}, 0), scratch(geometry) {
    observations[1].q = observations[1].qd = joints({0, 0});
    observations[1].known = true;
    observations[1].position_uncertainty = joints({0.2, 0.2});
    input.qd = joints({0, 0});
    input.has_goal = true;
    input.arms = observations;
  }

  TickStatus drive(const JointVector& from, const JointVector& to) {
    input.q = from;
    input.q_goal = to;
    TickResult result;
    for (int ticks = 0; ticks < 4000 && result.status != TickStatus::kReached; ++ticks) {
      result = tick(geometry, parameters, input, memory, scratch);
      input.q = result.q;
      input.qd = result.qd;
      nearest = std::min(nearest, input.q.norm());
    }
    return result.status;
  }

  CellGeometry geometry;
  std::array<ArmObservation, 2> observations;
  LocalParameters parameters;
  TickMemory memory{LocalMemory(1)};
  TickScratch scratch;
  TickInput input;
  double nearest = std::numeric_limits<double>::infinity();  ///< of the centres
};

TEST(Tick, AvoidsTheWholeStopSetOfALostArm) {
  BesideALostArm run;
  EXPECT_EQ(run.drive(joints({-1, 0}), joints({1, 0.1})), TickStatus::kReached);
  EXPECT_GE(run.nearest, 0.4 + 2 * 0.05 + run.parameters.damper.security_distance - 1e-9);
}

TEST(Tick, LeavesTheStopSetOfALostArmAndGoesNoDeeper) {
  BesideALostArm run;
  EXPECT_EQ(run.drive(joints({0.3, 0}), joints({1, 0})), TickStatus::kReached);
  EXPECT_GE(run.nearest, 0.3 - 1e-9);
  run.nearest = std::numeric_limits<double>::infinity();
  EXPECT_NE(run.drive(joints({0.3, 0}), joints({0.1, 0})), TickStatus::kReached);
  EXPECT_GE(run.nearest, 0.3 - 1e-9);
}

TEST(Tick, ArmWithoutGoalDoesNotFleeALostArm) {
  BesideALostArm run;
  run.input.has_goal = false;
  run.drive(joints({0.3, 0}), joints({0.3, 0}));
  EXPECT_EQ(run.input.q, joints({0.3, 0}));
}

// Two walls close in, at 0.2 m/s and 0.1 m/s. No retreat satisfies both rows. The arm retreats from the faster wall as
// long as there is space.
TEST(Tick, RetreatsAsFarAsPossibleWhenNotAllRowsCanHold) {
  CellGeometry geometry({test::planar_point("own")}, 0);
  geometry.set_obstacles(std::vector{box_obstacle("left", {-0.3, 0, 0}, {0.1, 9, 0.2}),
                                     box_obstacle("right", {0.3, 0, 0}, {0.1, 9, 0.2})});
  TickScratch scratch(geometry);
  const std::array<ArmObservation, 1> no_arms;
  std::array<world::ObstacleState, 2> walls;
  walls[0].X_WO.translation() = Eigen::Vector3d(-0.3, 0, 0);
  walls[0].velocity.linear = Eigen::Vector3d(0.2, 0, 0);
  walls[1].X_WO.translation() = Eigen::Vector3d(0.3, 0, 0);
  walls[1].velocity.linear = Eigen::Vector3d(-0.1, 0, 0);
  TickInput input;
  input.q = joints({0, 0});
  input.qd = joints({0, 0});
  input.q_goal = joints({0, 0});
  input.has_goal = true;
  input.arms = no_arms;
  input.obstacles = walls;
  TickMemory memory{LocalMemory(1)};
  const LocalParameters parameters;
  // Their surfaces are 0.4 m apart and the ball 0.1 m wide: it is squeezed after 1 s. Had it stayed in the middle, the
  // left one would have touched it after 0.75 s.
  bool relaxed = false;
  for (double now = 0.0; now < 0.9; now += input.dt) {
    const TickResult result = tick(geometry, parameters, input, memory, scratch);
    relaxed = relaxed || result.relaxed;
    input.q = result.q;
    input.qd = result.qd;
    for (auto& wall : walls) wall.X_WO.translation() += wall.velocity.linear * input.dt;
    ASSERT_GT(input.q[0] - 0.05, walls[0].X_WO.translation().x() + 0.1)
        << "touched from the left after " << now << " s";
    ASSERT_LT(input.q[0] + 0.05, walls[1].X_WO.translation().x() - 0.1)
        << "touched from the right after " << now << " s";
  }
  EXPECT_TRUE(relaxed) << "or nothing was tried";
}

// The arm does not pursue its goal because of the other arm, but still retreats from the wall.
TEST(Tick, GivesWayWhileAnArmStateIsTooOld) {
  CellGeometry geometry({test::planar_point("own"), test::planar_point("silent")}, 0);
  geometry.set_obstacles(std::vector{box_obstacle("cart", {-0.5, 0, 0}, {0.1, 0.5, 0.2})});
  TickScratch scratch(geometry);
  std::array<ArmObservation, 2> observations;
  observations[1].q = joints({0, 2});
  observations[1].qd = joints({0, 0});
  observations[1].known = observations[1].plans = true;
  observations[1].age = 0.5;
  std::array<world::ObstacleState, 1> states;
  states[0].X_WO.translation() = Eigen::Vector3d(-0.5, 0, 0);
  states[0].velocity.linear = Eigen::Vector3d(0.1, 0, 0);
  TickInput input;
  input.q = joints({0, 0});
  input.qd = joints({0, 0});
  input.q_goal = joints({0, 1});
  input.has_goal = true;
  input.arms = observations;
  input.obstacles = states;
  TickMemory memory{LocalMemory(1)};
  const LocalParameters parameters;
  for (int k = 0; k < 1000; ++k) {
    const TickResult result = tick(geometry, parameters, input, memory, scratch);
    ASSERT_EQ(result.status, TickStatus::kStaleInput);
    EXPECT_EQ(result.stale_arm, 1);
    input.q = result.q;
    input.qd = result.qd;
    states[0].X_WO.translation().x() += 0.1 * input.dt;
    ASSERT_GT(input.q[0] - 0.05 - (states[0].X_WO.translation().x() + 0.1), 0.0)
        << "run over after " << k << " periods";
    EXPECT_LE(input.q[1], 1e-9) << "towards where the other may be";
  }
  EXPECT_GT(input.q[0], 0.6);
  states[0].age = 1.0;
  EXPECT_LT(tick(geometry, parameters, input, memory, scratch).qd.norm(), input.qd.norm()) << "now it sees nothing";
}

}  // namespace
}  // namespace hecaton::planner
