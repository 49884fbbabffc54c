// Speed limits of an arm during a retreat (docs/explanation/0001-braking.md, "Flight"), on the planar point.
#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "planner/tick.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::box_obstacle;
using test::joints;
using test::kPeriod;

/// A point of radius 0.05 m at (0, 0), 2 m/s fast, whose longest stop takes 0.5 s. The default damper counts on
/// S₀ = 0.1 m / 1 m/s, so that near bodies it moves no faster than 4 · (0.1 − 0.01) = 0.36 m/s in each joint.
class Flight : public testing::Test {
 protected:
  Flight() {
    arm_ = test::planar_point();
    arm_.limits.velocity = joints({2, 2});
    arm_.limits.acceleration = joints({4, 4});
  }

  /// The greatest speed of any joint within `seconds`, towards `goal`, beside a box that moves at `v` [m/s].
  double fastest(const world::Obstacle& box, const Eigen::Vector3d& v, const JointVector& goal, double seconds) {
    CellGeometry geometry({arm_}, 0);
    geometry.set_obstacles(std::array{box});
    TickScratch scratch(geometry);
    TickMemory memory{LocalMemory(1)};
    const std::array<ArmObservation, 1> no_arms;
    std::array<world::ObstacleState, 1> states{world::ObstacleState{box.X_WO, {}, 0.0}};
    states[0].velocity.linear = v;
    TickInput input;
    input.dt = kPeriod;
    input.q = input.qd = joints({0, 0});
    input.q_goal = goal;
    input.has_goal = true;
    input.arms = no_arms;
    input.obstacles = states;
    double fastest = 0.0;
    for (double t = 0.0; t < seconds; t += kPeriod) {
      const TickResult result = tick(geometry, {}, input, memory, scratch);
      input.q = result.q;
      input.qd = result.qd;
      states[0].X_WO = world::extrapolate(states[0].X_WO, states[0].velocity, kPeriod);
      fastest = std::max(fastest, result.qd.cwiseAbs().maxCoeff());
    }
    return fastest;
  }

  static constexpr double kNear = 0.36;  // [m/s]
  Arm arm_;
};

// A wall along the path, 1 mm nearer than dₛ: a retreat at 10 mm/s is sufficient.
TEST_F(Flight, LimitsSpeedSlightlyInsideSecurityDistanceOfStaticObstacle) {
  const auto wall = box_obstacle("wall", {0, -0.05 - 0.019 - 0.1, 0}, {5, 0.1, 0.1});
  EXPECT_NEAR(fastest(wall, {0, 0, 0}, joints({1, 0}), 0.5), kNear, 1e-9);
}

// The arm retreats from a body at 0.5 m/s at the same speed, but no faster than an immediate stop allows.
TEST_F(Flight, DoublesSpeedLimitAtMostBeforeFastObstacle) {
  const auto ram = box_obstacle("ram", {-0.25, 0, 0}, {0.1, 0.5, 0.1});
  const double speed = fastest(ram, {0.5, 0, 0}, joints({0, 0}), 0.6);
  EXPECT_GT(speed, 1.2 * kNear);
  EXPECT_LE(speed, 2.0 * kNear + 1e-9);
}

}  // namespace
}  // namespace hecaton::planner
