// A rollout equals the ticks of all arms.
#include "planner/rollout/rollout_simulation.hpp"

#include <array>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::box_obstacle;
using test::joints;

constexpr double kStep = 0.02;

RolloutArm on_the_way(const JointVector& from, const JointVector& to) {
  RolloutArm arm;
  arm.q = from;
  arm.qd = joints({0, 0});
  arm.q_goal = to;
  arm.has_goal = true;
  arm.plans = true;
  return arm;
}

TEST(RolloutSimulation, MovesAnArmAsItsTicksDo) {
  const std::vector<world::Obstacle> boxes = {box_obstacle("box", {0.0, 0.6, 0}, {0.2, 0.2, 0.1})};
  RolloutSimulation cell({test::planar_point()}, {LocalParameters{}}, kStep);
  cell.set_obstacles(boxes);
  const std::array<world::ObstacleState, 1> states{world::ObstacleState{boxes[0].X_WO, {}, 0.0}};
  const std::array<RolloutArm, 1> start{on_the_way(joints({-1, 0}), joints({1, 0.2}))};
  cell.begin(start, states);

  CellGeometry geometry({test::planar_point()}, 0);
  geometry.set_obstacles(boxes);
  TickScratch scratch(geometry);
  TickMemory memory{start[0].memory};
  const std::array<ArmObservation, 1> no_arms{};
  TickInput input;
  input.dt = kStep;
  input.q = start[0].q;
  input.qd = start[0].qd;
  input.q_goal = start[0].q_goal;
  input.has_goal = true;
  input.arms = no_arms;
  input.obstacles = states;
  for (int k = 0; k < 50; ++k) {
    const TickResult result = tick(geometry, LocalParameters{}, input, memory, scratch);
    input.q = result.q;
    input.qd = result.qd;
    cell.step();
    ASSERT_EQ(cell.arm(0).q, input.q) << "step " << k;
    ASSERT_EQ(cell.arm(0).qd, input.qd) << "step " << k;
  }
  EXPECT_DOUBLE_EQ(cell.time(), 50 * kStep);
}

TEST(RolloutSimulation, ReportsWhenAnArmReachesItsGoal) {
  RolloutSimulation cell({test::planar_point()}, {LocalParameters{}}, kStep);
  cell.begin(std::array{on_the_way(joints({0, 0}), joints({0.5, 0}))}, {});
  EXPECT_LT(cell.reached(0), 0.0);
  while (cell.time() < 10.0) cell.step();
  EXPECT_GT(cell.reached(0), 1.0);  // 0.5 m at no more than 0.5 m/s
  EXPECT_LT(cell.reached(0), 10.0);
  const double first = cell.reached(0);
  cell.step();
  EXPECT_EQ(cell.reached(0), first);
}

TEST(RolloutSimulation, ArmThatOthersMoveGoesOnToItsLimit) {
  RolloutSimulation cell({test::planar_point()}, {LocalParameters{}}, kStep);
  RolloutArm arm = on_the_way(joints({2.9, 0}), joints({0, 0}));
  arm.plans = false;
  arm.foreign = true;
  arm.qd = joints({0.5, 0.1});
  cell.begin(std::array{arm}, {});
  cell.step();
  EXPECT_NEAR((cell.arm(0).q - joints({2.91, 0.002})).norm(), 0.0, 1e-12);
  for (int k = 0; k < 19; ++k) cell.step();
  EXPECT_NEAR((cell.arm(0).q - joints({3.0, 0.04})).norm(), 0.0, 1e-12);
  EXPECT_EQ(cell.arm(0).qd, joints({0.0, 0.1}));
}

TEST(RolloutSimulation, UnplannedArmStandsStill) {
  RolloutSimulation cell({test::planar_point()}, {LocalParameters{}}, kStep);
  RolloutArm arm = on_the_way(joints({0, 0}), joints({0.5, 0}));
  arm.plans = false;
  cell.begin(std::array{arm}, {});
  for (int k = 0; k < 20; ++k) cell.step();
  EXPECT_EQ(cell.arm(0).q, arm.q);
}

// The box comes from the right at 0.5 m/s; a point without goal must give way before it arrives.
TEST(RolloutSimulation, ObstaclesKeepTheirVelocity) {
  const std::vector<world::Obstacle> boxes = {box_obstacle("box", {1.0, 0.02, 0}, {0.1, 0.1, 0.1})};
  RolloutSimulation cell({test::planar_point()}, {LocalParameters{}}, kStep);
  cell.set_obstacles(boxes);
  world::ObstacleState moving{boxes[0].X_WO, {}, 0.0};
  moving.velocity.linear = {-0.5, 0, 0};
  RolloutArm arm = on_the_way(joints({0, 0}), joints({0, 0}));
  arm.has_goal = false;
  cell.begin(std::array{arm}, std::array{moving});
  while (cell.time() < 2.0) cell.step();
  EXPECT_GT((cell.arm(0).q - arm.q).norm(), 0.05);
}

}  // namespace
}  // namespace hecaton::planner
