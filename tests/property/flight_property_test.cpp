// The limit of docs/explanation/0001-braking.md, "Flight", by hand: a ball whose C-space is the plane moves along a
// wall while a faster body pushes it. Normals are constant, so that the inequality of the note holds exactly.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

constexpr double kPeriod = 0.01;    // [s]
constexpr double kRadius = 0.05;    // of the ball and of what drives it [m]
constexpr double kWall = 1.0;       // x of its face [m]
constexpr double kRounding = 1e-9;  // [m]

struct Tally {
  int ticks = 0;       ///< in which all rows hold
  int flights = 0;     ///< of these, with stops longer than S − dt
  int beyond = 0;      ///< of these, with stops longer than 2 (S − dt)
  double least = 1.0;  ///< distance from dₛ after an immediate stop over the present one; < 0: inside dₛ
};

void drive_along_the_wall(Random& random, Tally& tally) {
  Arm arm = test::planar_point("ball", kRadius);
  const double speed = random.uniform(0.5, 2.0);
  arm.limits.velocity.setConstant(speed);
  arm.limits.acceleration.setConstant(speed / random.uniform(0.4, 1.0));
  LocalParameters parameters;
  parameters.damper = {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55};
  parameters.rollout.candidates = 0;
  parameters.replanning.stall_timeout = 0.0;
  ArmController controller(CellGeometry({arm}, 0), parameters, kPeriod, random.next());
  std::vector<world::Obstacle> things = {test::box_obstacle("wall", {kWall + 0.5, 0, 0}, {0.5, 9, 1})};
  things.emplace_back().name = "driver";
  things.back().shapes.push_back({world::Sphere{kRadius}, world::Pose::Identity()});
  controller.set_obstacles(things);
  controller.set_goal(joints({2.5, 2.9}));

  const double left_at_start = random.uniform(0.02, 0.2);
  MeasuredState own{joints({kWall - kRadius - parameters.damper.security_distance - left_at_start, -1.5}),
                    joints({0, 0})};
  std::vector<world::ObstacleState> states(2);
  states[0].X_WO = things[0].X_WO;
  states[1].X_WO.translation() =
      Eigen::Vector3d(own.q[0] - random.uniform(0.0, 0.05), -1.7 - random.uniform(0.0, 0.3), 0);
  states[1].velocity.linear = Eigen::Vector3d(0.0, random.uniform(0.2, 0.6) * speed, 0.0);
  const Damper damper = parameters.damper.against_others(kPeriod + longest_stop_time(arm.limits));
  const std::vector<ArmObservation> no_arms(1);
  for (int tick = 0; tick < 150; ++tick) {
    const double distance = kWall - kRadius - own.q[0];
    const double stop_before = damper.time_constant(distance) - kPeriod;
    const TickResult result = controller.step(own, no_arms, states, false);
    own = {result.q, result.qd};
    states[1].X_WO.translation() += kPeriod * states[1].velocity.linear;
    if (result.relaxed) continue;
    const double stop = stop_time(arm.limits, own.qd);
    const double left = distance - damper.security_distance;
    const double at_rest = kWall - kRadius - damper.security_distance - rest_position(arm.limits, own.q, own.qd)[0];
    ++tally.ticks;
    tally.flights += stop > stop_before + kRounding ? 1 : 0;
    tally.beyond += stop > 2.0 * stop_before + kRounding ? 1 : 0;
    if (left > 1e-4) tally.least = std::min(tally.least, at_rest / left);
  }
}

TEST(FlightProperty, ImmediateStopEndsBeforeStaticObstacles) {
  Random random(11);
  Tally tally;
  for (int trial = 0; trial < 300; ++trial) drive_along_the_wall(random, tally);
  std::printf("%d ticks, %d in flight, %d beyond, nearest rest %.4f of the way left\n", tally.ticks, tally.flights,
              tally.beyond, tally.least);
  EXPECT_GT(tally.flights, tally.ticks / 20) << "or nothing was tried";
  // Where S = x/ξ the limit of a flight may fall by 2 dt a period, and braking follows by dt: hence not none, and not
  // 0.
  EXPECT_LE(tally.beyond, tally.flights / 1000);
  EXPECT_GE(tally.least, -0.02);
}

}  // namespace
}  // namespace hecaton::planner
