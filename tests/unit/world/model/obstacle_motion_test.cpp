#include "world/model/obstacle_motion.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/sim/small_worlds.hpp"

namespace hecaton::world {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

Obstacle scripted(Motion motion, const Pose& X_WO = Pose::Identity()) {
  Obstacle obstacle;
  obstacle.name = "thing";
  obstacle.shapes = {{Sphere{0.1}, Pose::Identity()}};
  obstacle.X_WO = X_WO;
  obstacle.motion = std::move(motion);
  return obstacle;
}

void expect_point(const Vector3d& actual, const Vector3d& expected, double tolerance = 1e-12) {
  EXPECT_LT((actual - expected).norm(), tolerance) << "got " << actual.transpose() << ", not " << expected.transpose();
}

/// The twist against central differences of the pose.
void expect_twist_is_derivative(const Obstacle& obstacle, double time) {
  const double h = 1e-6;
  const Pose before = motion_at(obstacle, time - h).X_WO;
  const Pose after = motion_at(obstacle, time + h).X_WO;
  const Twist twist = motion_at(obstacle, time).velocity;
  expect_point(twist.linear, (after.translation() - before.translation()) / (2 * h), 1e-6);
  const Eigen::AngleAxisd turn(after.linear() * before.linear().transpose());
  expect_point(twist.angular, turn.axis() * turn.angle() / (2 * h), 1e-6);
}

TEST(ObstacleMotion, OnlyScriptsCountAsScripted) {
  EXPECT_FALSE(is_scripted(StaticMotion{}));
  EXPECT_FALSE(is_scripted(DynamicMotion{}));
  EXPECT_TRUE(is_scripted(WaypointMotion{}));
  EXPECT_TRUE(is_scripted(CircleMotion{}));
  EXPECT_TRUE(is_scripted(SineMotion{}));
  EXPECT_TRUE(is_scripted(ConveyorMotion{}));
}

TEST(ObstacleMotion, StaticKeepsItsPose) {
  const Obstacle obstacle = scripted(StaticMotion{}, at_point(1, 2, 3));
  for (const double time : {-5.0, 0.0, 1e6}) {
    const MotionState state = motion_at(obstacle, time);
    expect_point(state.X_WO.translation(), {1, 2, 3});
    expect_point(state.velocity.linear, Vector3d::Zero());
    expect_point(state.velocity.angular, Vector3d::Zero());
  }
}

TEST(ObstacleMotion, DynamicReportsItsInitialState) {
  DynamicMotion motion;
  motion.initial_velocity.linear = {1, 0, 0};
  const MotionState state = motion_at(scripted(motion, at_point(0, 0, 1)), 7.0);
  expect_point(state.X_WO.translation(), {0, 0, 1});
  expect_point(state.velocity.linear, {1, 0, 0});
}

// Triangle 3–4–5 m at 2 m/s: corners at 0, 1.5, 3.5 and 6 s.
WaypointMotion triangle(bool loop) {
  return {{at_point(0, 0, 0), at_point(3, 0, 0), at_point(3, 4, 0)}, 2.0, loop};
}

TEST(ObstacleMotion, WaypointsLoop) {
  const Obstacle obstacle = scripted(triangle(true), at_point(9, 9, 9));
  expect_point(motion_at(obstacle, 0.0).X_WO.translation(), {0, 0, 0});
  expect_point(motion_at(obstacle, 1.0).X_WO.translation(), {2, 0, 0});
  expect_point(motion_at(obstacle, 2.5).X_WO.translation(), {3, 2, 0});
  // Half-way down the hypotenuse, 2.5 m of 5 m: direction (−3, −4)/5.
  expect_point(motion_at(obstacle, 4.75).X_WO.translation(), {1.5, 2, 0});
  expect_point(motion_at(obstacle, 4.75).velocity.linear, {-1.2, -1.6, 0});
  expect_point(motion_at(obstacle, 7.0).X_WO.translation(), {2, 0, 0});
  expect_point(motion_at(obstacle, -0.5).X_WO.translation(), {0.6, 0.8, 0});
}

TEST(ObstacleMotion, WaypointsGoBackAndForth) {
  const Obstacle obstacle = scripted(triangle(false));
  expect_point(motion_at(obstacle, 3.0).X_WO.translation(), {3, 3, 0});
  // One way is 7 m, 3.5 s.
  expect_point(motion_at(obstacle, 4.0).X_WO.translation(), {3, 3, 0});
  expect_point(motion_at(obstacle, 4.0).velocity.linear, {0, -2, 0});
  expect_point(motion_at(obstacle, 6.0).X_WO.translation(), {2, 0, 0});
  expect_point(motion_at(obstacle, 8.0).X_WO.translation(), {2, 0, 0});
}

TEST(ObstacleMotion, TakesTheNextLineAtAWaypoint) {
  expect_point(motion_at(scripted(triangle(true)), 1.5).velocity.linear, {0, 2, 0});
  expect_point(motion_at(scripted(triangle(true)), 6.0).velocity.linear, {2, 0, 0});
  expect_point(motion_at(scripted(triangle(false)), 3.5).velocity.linear, {0, -2, 0});
  expect_point(motion_at(scripted(triangle(false)), 7.0).velocity.linear, {2, 0, 0});
}

TEST(ObstacleMotion, WaypointsRotateBySlerp) {
  Pose turned = at_point(1, 0, 0);
  turned.linear() = Eigen::AngleAxisd(pi / 2, Vector3d::UnitZ()).toRotationMatrix();
  const Obstacle obstacle = scripted(WaypointMotion{{at_point(0, 0, 0), turned}, 0.5, false});
  // 1 m at 0.5 m/s: a quarter turn in 2 s, so π/4 rad/s, and 45° half-way.
  const MotionState state = motion_at(obstacle, 1.0);
  expect_point(state.X_WO.linear() * Vector3d::UnitX(), {std::sqrt(0.5), std::sqrt(0.5), 0});
  expect_point(state.velocity.angular, {0, 0, pi / 4});
  expect_point(motion_at(obstacle, 3.0).velocity.angular, {0, 0, -pi / 4});
}

TEST(ObstacleMotion, WaypointsAtOnePositionRest) {
  const Obstacle obstacle = scripted(WaypointMotion{{at_point(1, 0, 0), at_point(1, 0, 0)}, 0.5, true});
  expect_point(motion_at(obstacle, 3.0).X_WO.translation(), {1, 0, 0});
  expect_point(motion_at(obstacle, 3.0).velocity.linear, Vector3d::Zero());
}

TEST(ObstacleMotion, CircleStartsAtItsOwnPose) {
  const CircleMotion motion{{1, 0, 0}, Vector3d::UnitZ(), pi / 2, false};
  const Obstacle obstacle = scripted(motion, at_point(3, 0, 0.5));
  expect_point(motion_at(obstacle, 0.0).X_WO.translation(), {3, 0, 0.5});
  expect_point(motion_at(obstacle, 1.0).X_WO.translation(), {1, 2, 0.5});
  // Radius 2 m at π/2 rad/s: π m/s, at the top towards −x.
  expect_point(motion_at(obstacle, 1.0).velocity.linear, {-pi, 0, 0});
  expect_point(motion_at(obstacle, 1.0).velocity.angular, Vector3d::Zero());
  expect_point(motion_at(obstacle, 1.0).X_WO.linear() * Vector3d::UnitX(), {1, 0, 0});
}

TEST(ObstacleMotion, CircleCanRotateTheBody) {
  const CircleMotion motion{{1, 0, 0}, Vector3d::UnitZ(), -pi / 2, true};
  const MotionState state = motion_at(scripted(motion, at_point(3, 0, 0)), 1.0);
  expect_point(state.X_WO.translation(), {1, -2, 0});
  expect_point(state.X_WO.linear() * Vector3d::UnitX(), {0, -1, 0});
  expect_point(state.velocity.angular, {0, 0, -pi / 2});
}

TEST(ObstacleMotion, SineSwingsAroundItsOwnPose) {
  const Obstacle obstacle = scripted(SineMotion{Vector3d::UnitY(), 0.2, 4.0, pi / 6}, at_point(1, 1, 1));
  // sin 30° = 1/2; velocity 0.2 · 2π/4 · cos 30°.
  expect_point(motion_at(obstacle, 0.0).X_WO.translation(), {1, 1.1, 1});
  expect_point(motion_at(obstacle, 0.0).velocity.linear, {0, 0.1 * pi * std::sqrt(3.0) / 2.0, 0});
  // A quarter period on: sin 120° = √3/2.
  expect_point(motion_at(obstacle, 1.0).X_WO.translation(), {1, 1 + 0.1 * std::sqrt(3.0), 1});
}

TEST(ObstacleMotion, ConveyorRestartsAtItsLength) {
  const Obstacle obstacle = scripted(ConveyorMotion{Vector3d::UnitX(), 0.5, 2.0}, at_point(1, 0, 0));
  expect_point(motion_at(obstacle, 3.0).X_WO.translation(), {2.5, 0, 0});
  expect_point(motion_at(obstacle, 4.0).X_WO.translation(), {1, 0, 0});
  expect_point(motion_at(obstacle, 9.0).X_WO.translation(), {1.5, 0, 0});
}

TEST(ObstacleMotion, ConveyorRunsBackwardsWithNegativeSpeed) {
  const Obstacle obstacle = scripted(ConveyorMotion{Vector3d::UnitX(), -0.5, 2.0}, at_point(1, 0, 0));
  expect_point(motion_at(obstacle, 3.0).X_WO.translation(), {-0.5, 0, 0});
  expect_point(motion_at(obstacle, 5.0).X_WO.translation(), {0.5, 0, 0});
}

TEST(ObstacleMotion, ConveyorJumpDoesNotChangeTheTwist) {
  const Obstacle obstacle = scripted(ConveyorMotion{Vector3d::UnitX(), 0.5, 2.0});
  for (const double time : {4.0 - 1e-9, 4.0, 4.0 + 1e-9}) {
    expect_point(motion_at(obstacle, time).velocity.linear, {0.5, 0, 0});
  }
}

TEST(ObstacleMotion, TwistIsTheDerivativeOfThePose) {
  const Pose start = pose_from_xyz_rpy({0.3, -0.2, 0.5}, {0.4, -0.3, 1.2});
  const Vector3d axis = Vector3d(1, 2, 3).normalized();
  const WaypointMotion waypoints{
      {start, pose_from_xyz_rpy({1, 1, 0}, {-1.0, 0.5, 2.0}), pose_from_xyz_rpy({0, 1, 1}, {3.0, 0.1, -2.5})},
      0.3,
      true};
  for (const Obstacle& obstacle :
       {scripted(waypoints), scripted(CircleMotion{{1, 1, 0}, axis, 0.7, true}, start),
        scripted(SineMotion{axis, 0.4, 3.0, 0.2}, start), scripted(ConveyorMotion{axis, 0.3, 1.0}, start)}) {
    for (const double time : {0.1, 1.3, 2.9, 6.1, 11.7}) expect_twist_is_derivative(obstacle, time);
  }
}

TEST(ObstacleMotion, GreatestAccelerationBoundsEveryScript) {
  const Vector3d axis = Vector3d(1, 2, 3).normalized();
  for (const Obstacle& obstacle :
       {scripted(CircleMotion{{1, 1, 0}, axis, 1.7, false}, at_point(0.3, -0.2, 0.5)),
        scripted(SineMotion{axis, 0.4, 3.0, 0.2}), scripted(ConveyorMotion{axis, 0.3, 100.0})}) {
    double most = 0.0;
    for (double time = 0.0; time < 6.0; time += 0.01) {
      const double h = 1e-5;
      const Vector3d before = motion_at(obstacle, time - h).velocity.linear;
      most = std::max(most, (motion_at(obstacle, time + h).velocity.linear - before).norm() / (2 * h));
    }
    EXPECT_NEAR(most, greatest_acceleration(obstacle), 1e-3);
  }
  EXPECT_EQ(greatest_acceleration(scripted(StaticMotion{})), 0.0);
}

TEST(ObstacleMotion, BreaksAreJumpsOfPoseOrVelocity) {
  WaypointMotion there_and_back;
  there_and_back.poses_W = {at_point(0, 0, 0), at_point(1, 0, 0), at_point(3, 0, 0)};
  there_and_back.speed = 0.4;
  there_and_back.loop = false;
  const auto turns = script_breaks(scripted(there_and_back));
  ASSERT_EQ(turns.size(), 2U) << "it goes straight on at the one between";
  EXPECT_TRUE(turns[0].X_WO.translation().isApprox(Vector3d(0, 0, 0)));
  EXPECT_TRUE(turns[1].X_WO.translation().isApprox(Vector3d(3, 0, 0)));
  for (const ScriptBreak& turn : turns) {
    EXPECT_NEAR(turn.velocity_change, 0.8, 1e-12);
    EXPECT_EQ(turn.jump, 0.0);
  }
  const auto restarts = script_breaks(scripted(ConveyorMotion{{0, 1, 0}, 0.3, 2.5}, at_point(1, 0, 0)));
  ASSERT_EQ(restarts.size(), 1U);
  EXPECT_TRUE(restarts[0].X_WO.translation().isApprox(Vector3d(1, 0, 0)));
  EXPECT_EQ(restarts[0].jump, 2.5);
  EXPECT_TRUE(script_breaks(scripted(CircleMotion{{1, 1, 0}, {0, 0, 1}, 0.7, true})).empty());
}

TEST(ObstacleMotion, RepeatsAfterItsPeriod) {
  const Pose start = at_point(0.3, -0.2, 0.5);
  for (const Obstacle& obstacle :
       {scripted(triangle(true)), scripted(triangle(false)),
        scripted(CircleMotion{{1, 1, 0}, {0, 0, 1}, -0.7, true}, start),
        scripted(SineMotion{{0, 0, 1}, 0.4, 3.0, 0.2}, start), scripted(ConveyorMotion{{1, 0, 0}, -0.3, 1.0}, start)}) {
    const double period = script_period(obstacle);
    EXPECT_GT(period, 1.0);
    for (const double time : {0.1, 0.7, 1.3}) {
      const Pose later = motion_at(obstacle, time + period).X_WO;
      EXPECT_LT((motion_at(obstacle, time).X_WO.matrix() - later.matrix()).norm(), 1e-9);
      EXPECT_GT((motion_at(obstacle, time + 0.5 * period).X_WO.matrix() - later.matrix()).norm(), 1e-3);
    }
  }
  EXPECT_EQ(script_period(scripted(StaticMotion{})), 0.0);
}

TEST(ObstacleMotion, IsDefinedAtAnyTimeOfALongScript) {
  // Lengths that binary fractions cannot add up exactly: the end of a round must not fall between two stretches.
  const WaypointMotion motion{{at_point(0, 0, 0), at_point(0.1, 0, 0), at_point(0.1, 0.7, 0)}, 0.3, false};
  const Obstacle obstacle = scripted(motion);
  for (int i = 0; i < 10000; ++i) {
    const MotionState state = motion_at(obstacle, i * (1.6 / 0.3) / 4.0);
    ASSERT_NEAR(state.velocity.linear.norm(), 0.3, 1e-12);
    ASSERT_LE(state.X_WO.translation().y(), 0.7 + 1e-9);
  }
}

}  // namespace
}  // namespace hecaton::world
