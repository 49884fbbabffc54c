#include "world/sim/bullet_world.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

namespace hecaton::world {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;
constexpr double kGravity = 9.81;

Pose at_point(double x, double y, double z) {
  Pose pose = Pose::Identity();
  pose.translation() = Vector3d(x, y, z);
  return pose;
}

Obstacle thing(const std::string& name, const Shape& shape, const Pose& X_WO, Motion motion = StaticMotion{}) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.shapes = {{shape, Pose::Identity()}};
  obstacle.X_WO = X_WO;
  obstacle.motion = std::move(motion);
  return obstacle;
}

DynamicMotion falling(double restitution = 0.0) {
  DynamicMotion motion;
  motion.restitution = restitution;
  return motion;
}

/// One link, a box of 0.1 m, at the tool frame.
ArmBodies box_arm(const std::string& name) {
  ArmBodies arm;
  arm.name = name;
  arm.parts.push_back({0, "hand", {Box{Vector3d(0.05, 0.05, 0.05)}, Pose::Identity()}, true});
  arm.grasp_links = {0};
  return arm;
}

BulletWorld world_of(std::vector<Obstacle> obstacles, std::vector<ArmBodies> arms = {}) {
  Scene scene;
  scene.obstacles = std::move(obstacles);
  return {scene, std::move(arms)};
}

bool put_arm(BulletWorld& world, int arm, const Pose& X_WT) {
  return world.set_arm(arm, std::span(&X_WT, 1), X_WT);
}

Vector3d place(const BulletWorld& world, int obstacle = 0) {
  return world.snapshot().states[obstacle].X_WO.translation();
}

void expect_point(const Vector3d& actual, const Vector3d& expected, double tolerance) {
  EXPECT_LT((actual - expected).norm(), tolerance) << "got " << actual.transpose() << ", not " << expected.transpose();
}

TEST(BulletWorld, ScriptsFollowTheWorldsTime) {
  BulletWorld world =
      world_of({thing("belt", Sphere{0.1}, at_point(1, 0, 0), ConveyorMotion{Vector3d::UnitX(), 0.5, 2.0}),
                thing("post", Sphere{0.1}, at_point(0, 1, 0))});
  for (int i = 0; i < 100; ++i) world.step(0.01);
  EXPECT_NEAR(world.time(), 1.0, 1e-12);
  expect_point(place(world, 0), {1.5, 0, 0}, 1e-9);
  expect_point(place(world, 1), {0, 1, 0}, 1e-12);
  EXPECT_NEAR(world.snapshot().states[0].velocity.linear.x(), 0.5, 1e-12);
  world.set_time(3.0);
  expect_point(place(world, 0), {2.5, 0, 0}, 1e-9);
  EXPECT_EQ(world.snapshot().time, 3.0);
}

TEST(BulletWorld, SnapshotsCountStepsAndEditions) {
  BulletWorld world = world_of({thing("post", Sphere{0.1}, at_point(0, 1, 0))});
  EXPECT_EQ(world.snapshot().sequence, 0U);
  world.step(0.01);
  world.step(0.01);
  EXPECT_EQ(world.snapshot().sequence, 2U);
  const auto edition = world.snapshot().edition;
  EXPECT_TRUE(world.move("post", at_point(0, 2, 0)).done);
  EXPECT_EQ(world.snapshot().edition, edition);
  EXPECT_TRUE(world.add(thing("crate", Sphere{0.1}, at_point(0, 3, 0))).done);
  EXPECT_EQ(world.snapshot().edition, edition + 1);
  EXPECT_TRUE(world.remove("post").done);
  EXPECT_EQ(world.snapshot().edition, edition + 2);
  ASSERT_EQ(world.snapshot().states.size(), 1U);
  expect_point(place(world), {0, 3, 0}, 1e-12);
}

TEST(BulletWorld, ABodyFallsAsGalileoSays) {
  BulletWorld world = world_of({thing("ball", Sphere{0.1}, at_point(0, 0, 2.1), falling())});
  // Half a second: ½ g t² = 1.226 m. Symplectic Euler is ahead by ½ g h t ≤ 12.3 mm at 5 ms.
  for (int i = 0; i < 100; ++i) world.step(0.005);
  EXPECT_NEAR(place(world).z(), 2.1 - 0.5 * kGravity * 0.25, 0.013);
  EXPECT_NEAR(world.snapshot().states[0].velocity.linear.z(), -kGravity * 0.5, 1e-9);
}

TEST(BulletWorld, ABodyLandsInTimeAndRests) {
  BulletWorld world = world_of({thing("box", Box{Vector3d(0.1, 0.1, 0.1)}, at_point(0, 0, 1.1), falling())});
  // 1 m of free fall takes √(2/g) = 0.4515 s.
  while (place(world).z() > 0.105 && world.time() < 2.0) world.step(0.005);
  EXPECT_NEAR(world.time(), std::sqrt(2.0 / kGravity), 0.011);
  for (int i = 0; i < 400; ++i) world.step(0.005);
  expect_point(place(world), {0, 0, 0.1}, 2e-3);
  EXPECT_LT(world.snapshot().states[0].velocity.linear.norm(), 1e-2);
  EXPECT_LT(world.snapshot().states[0].velocity.angular.norm(), 1e-2);
}

TEST(BulletWorld, EveryShapeRestsOnTheFloorAtItsOwnHeight) {
  auto wedge = std::make_shared<ConvexHull>();
  // A prism 0.4 × 0.4 at the bottom, 0.2 high, its vertices far from its own origin.
  wedge->vertices = {{1, 1, 1}, {1.4, 1, 1}, {1.4, 1.4, 1}, {1, 1.4, 1}, {1.2, 1.1, 1.2}, {1.2, 1.3, 1.2}};
  wedge->faces = {{0, 3, 2, 1}, {0, 1, 4}, {2, 3, 5}, {1, 2, 5, 4}, {3, 0, 4, 5}};
  const Pose lying = pose_from_xyz_rpy({4, 0, 0.5}, {kPi / 2, 0, 0});
  BulletWorld world = world_of({thing("box", Box{Vector3d(0.3, 0.2, 0.1)}, at_point(0, 0, 0.3), falling()),
                                thing("ball", Sphere{0.15}, at_point(2, 0, 0.3), falling()),
                                thing("roll", Capsule{0.1, 0.3}, lying, falling()),
                                thing("can", Cylinder{0.2, 0.15}, at_point(6, 0, 0.3), falling()),
                                thing("wedge", Convex{wedge}, at_point(8, 0, -0.5), falling())});
  for (int i = 0; i < 600; ++i) world.step(0.005);
  EXPECT_NEAR(place(world, 0).z(), 0.1, 2e-3);
  EXPECT_NEAR(place(world, 1).z(), 0.15, 2e-3);
  EXPECT_NEAR(place(world, 2).z(), 0.1, 2e-3);
  EXPECT_NEAR(place(world, 3).z(), 0.15, 2e-3);
  // Its lowest vertices are 1 m above its origin.
  EXPECT_NEAR(place(world, 4).z(), -1.0, 2e-3);
  const auto states = world.snapshot().states;
  EXPECT_NEAR((states[4].X_WO.linear() * Vector3d::UnitZ()).z(), 1.0, 1e-3);
}

TEST(BulletWorld, TheFloorMayLieElsewhere) {
  Scene scene;
  scene.floor_z = -0.5;
  scene.obstacles = {thing("ball", Sphere{0.1}, at_point(0, 0, 0), falling())};
  BulletWorld world(scene, {});
  for (int i = 0; i < 600; ++i) world.step(0.005);
  EXPECT_NEAR(place(world).z(), -0.4, 2e-3);
}

TEST(BulletWorld, ASlidingBallRollsWithFiveSeventhsOfItsSpeed) {
  DynamicMotion motion = falling();
  motion.friction = 0.5;
  motion.rolling_friction = 0.0;
  motion.initial_velocity.linear = {1.4, 0, 0};
  BulletWorld world = world_of({thing("ball", Sphere{0.1}, at_point(0, 0, 0.1), motion)});
  // Friction turns sliding into rolling; a solid ball then has 5/7 of its speed, here 1 m/s, and turns at v/r.
  for (int i = 0; i < 200; ++i) world.step(0.005);
  const Twist velocity = world.snapshot().states[0].velocity;
  EXPECT_NEAR(velocity.linear.x(), 1.0, 0.03);
  EXPECT_NEAR(velocity.angular.y(), 10.0, 0.3);
  EXPECT_GT(place(world).x(), 0.9);
}

TEST(BulletWorld, RollingFrictionStopsABall) {
  DynamicMotion motion = falling();
  motion.rolling_friction = 0.05;
  motion.initial_velocity.linear = {0.5, 0, 0};
  BulletWorld world = world_of({thing("ball", Sphere{0.1}, at_point(0, 0, 0.1), motion)});
  for (int i = 0; i < 2000; ++i) world.step(0.005);
  EXPECT_LT(world.snapshot().states[0].velocity.linear.norm(), 1e-2);
}

TEST(BulletWorld, AnArmPushesABodyAndTheRefereeSeesIt) {
  BulletWorld world =
      world_of({thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0.3, 0, 0.05), falling())}, {box_arm("arm1")});
  // 0.2 m/s along x for 2 s, from 0.2 m of clearance: touching after 1 s, then 0.2 m of push.
  for (int i = 0; i <= 200; ++i) {
    ASSERT_TRUE(put_arm(world, 0, at_point(0.002 * i, 0, 0.06)));
    world.step(0.01);
  }
  EXPECT_NEAR(place(world).x(), 0.5, 0.02);
  EXPECT_NEAR(world.snapshot().states[0].velocity.linear.x(), 0.2, 0.05);
  const RefereeReport report = world.referee().report();
  EXPECT_GE(report.kinds[static_cast<std::size_t>(ContactKind::kArmObstacle)].contacts, 1U);
  EXPECT_GT(report.smallest.distance, -0.01);
}

TEST(BulletWorld, AScriptedObstaclePushesABody) {
  BulletWorld world = world_of({thing("pusher", Box{Vector3d(0.05, 0.2, 0.05)}, at_point(0, 0, 0.06),
                                      ConveyorMotion{Vector3d::UnitX(), 0.2, 10}),
                                thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0.2, 0, 0.05), falling())});
  for (int i = 0; i < 200; ++i) world.step(0.01);
  // After 2 s the pusher's face is at 0.45.
  EXPECT_NEAR(place(world, 1).x(), 0.5, 0.02);
}

TEST(BulletWorld, ABodyRidesOnAMovingTray) {
  DynamicMotion motion = falling();
  motion.friction = 0.8;
  BulletWorld world = world_of(
      {thing("tray", Box{Vector3d(0.5, 0.5, 0.02)}, at_point(0, 0, 0.5), SineMotion{Vector3d::UnitX(), 0.2, 4.0, 0.0}),
       thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0, 0, 0.57), motion)});
  // The script starts with 0.31 m/s: one slide, then it rides along. 0.2 (2π/4)² = 0.49 m/s² is well below μ g.
  for (int i = 0; i < 100; ++i) world.step(0.01);
  const double offset = place(world, 1).x() - place(world, 0).x();
  for (int i = 0; i < 300; ++i) world.step(0.01);
  EXPECT_NEAR(place(world, 1).x() - place(world, 0).x(), offset, 0.01);
  EXPECT_NEAR(place(world, 1).z(), 0.57, 3e-3);
}

TEST(BulletWorld, ConveyorRestartHurlsNothing) {
  // The belt jumps back beneath a box that lies beside it; with the jump taken for a velocity of 100 m/s the box flies.
  BulletWorld world = world_of(
      {thing("belt", Box{Vector3d(0.2, 0.2, 0.05)}, at_point(0, 0, 0.05), ConveyorMotion{Vector3d::UnitX(), 0.5, 0.5}),
       thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0.1, 0, 0.152), falling())});
  for (int i = 0; i < 500; ++i) {
    world.step(0.01);
    ASSERT_LT(world.snapshot().states[1].velocity.linear.norm(), 2.0) << "at " << world.time();
  }
}

TEST(BulletWorld, UnknownArmsPushNothing) {
  BulletWorld world =
      world_of({thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0, 0, 0.05), falling())}, {box_arm("arm1")});
  for (int i = 0; i < 50; ++i) world.step(0.01);
  expect_point(place(world), {0, 0, 0.05}, 2e-3);
  EXPECT_FALSE(world.referee().report().judged);
}

TEST(BulletWorld, BadMeasurementsChangeNothing) {
  BulletWorld world = world_of({thing("post", Sphere{0.1}, at_point(0, 0, 1))}, {box_arm("arm1")});
  EXPECT_FALSE(put_arm(world, 1, at_point(0, 0, 0)));
  EXPECT_FALSE(put_arm(world, -1, at_point(0, 0, 0)));
  EXPECT_FALSE(world.set_arm(0, {}, at_point(0, 0, 0)));
  EXPECT_FALSE(put_arm(world, 0, at_point(0, std::numeric_limits<double>::quiet_NaN(), 0)));
  world.step(0.01);
  EXPECT_FALSE(world.referee().report().judged);
  EXPECT_TRUE(put_arm(world, 0, at_point(0, 0, 0)));
  world.step(0.01);
  EXPECT_TRUE(world.referee().report().judged);
}

TEST(BulletWorld, ImpossibleStepsThrow) {
  BulletWorld world = world_of({});
  EXPECT_THROW(world.step(-0.01), std::invalid_argument);
  EXPECT_THROW(world.step(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(world.set_time(std::numeric_limits<double>::infinity()), std::invalid_argument);
  EXPECT_NO_THROW(world.step(0.0));
}

TEST(BulletWorld, ImpossibleScenesThrow) {
  const Obstacle post = thing("post", Sphere{0.1}, at_point(0, 0, 1));
  EXPECT_THROW(world_of({post, post}), std::invalid_argument);
  EXPECT_THROW(world_of({thing("post", Sphere{0.0}, at_point(0, 0, 1))}), std::invalid_argument);
  Obstacle held = post;
  held.attachment = Attachment{"nobody", Pose::Identity()};
  EXPECT_THROW(world_of({held}), std::invalid_argument);
  EXPECT_THROW(world_of({}, {box_arm("arm1"), box_arm("arm1")}), std::invalid_argument);
  ArmBodies flat = box_arm("arm1");
  flat.parts[0].shape.shape = Box{Vector3d(0.1, 0.1, 0.0)};
  EXPECT_THROW(world_of({}, {flat}), std::invalid_argument);
}

TEST(BulletWorld, MoveEndsAScriptAndStopsAFall) {
  BulletWorld world =
      world_of({thing("belt", Sphere{0.1}, at_point(5, 0, 0), ConveyorMotion{Vector3d::UnitX(), 0.5, 2.0}),
                thing("ball", Sphere{0.1}, at_point(0, 0, 2), falling())});
  for (int i = 0; i < 20; ++i) world.step(0.01);
  EXPECT_TRUE(world.move("belt", at_point(7, 0, 0)).done);
  EXPECT_TRUE(world.move("ball", at_point(0, 0, 1.1)).done);
  EXPECT_EQ(world.snapshot().states[1].velocity.linear.norm(), 0.0);
  for (int i = 0; i < 10; ++i) world.step(0.01);
  expect_point(place(world, 0), {7, 0, 0}, 1e-12);
  EXPECT_EQ(world.snapshot().states[0].velocity.linear.norm(), 0.0);
  // Falls again, from rest: ½ g 0.1².
  EXPECT_NEAR(place(world, 1).z(), 1.1 - 0.5 * kGravity * 0.01, 0.003);
  ASSERT_TRUE(std::holds_alternative<DynamicMotion>(world.obstacles()[1].motion));
}

TEST(BulletWorld, WhatABodyLiesOnMayBeTakenAway) {
  BulletWorld world = world_of({thing("table", Box{Vector3d(0.3, 0.3, 0.1)}, at_point(0, 0, 0.9)),
                                thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0, 0, 1.05), falling())});
  for (int i = 0; i < 500; ++i) world.step(0.01);
  EXPECT_NEAR(place(world, 1).z(), 1.05, 2e-3);
  EXPECT_TRUE(world.remove("table").done);
  for (int i = 0; i < 200; ++i) world.step(0.01);
  EXPECT_NEAR(place(world, 0).z(), 0.05, 2e-3);
}

TEST(BulletWorld, AStackStandsStill) {
  const Box cube{Vector3d(0.1, 0.1, 0.1)};
  BulletWorld world = world_of({thing("low", cube, at_point(0, 0, 0.1), falling()),
                                thing("middle", cube, at_point(0, 0, 0.3), falling()),
                                thing("top", cube, at_point(0, 0, 0.5), falling())});
  for (int i = 0; i < 1000; ++i) world.step(0.01);
  for (int i = 0; i < 3; ++i) expect_point(place(world, i), {0, 0, 0.1 + 0.2 * i}, 5e-3);
}

TEST(BulletWorld, AttachedObstaclesFollowTheTool) {
  BulletWorld world = world_of({thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0.5, 0, 0.5), falling())},
                               {box_arm("arm1"), box_arm("arm2")});
  put_arm(world, 0, at_point(0.5, 0, 0.6));
  put_arm(world, 1, at_point(9, 0, 0.6));
  ASSERT_TRUE(world.attach("box", "arm1").done);
  ASSERT_TRUE(world.obstacles()[0].attachment.has_value());
  expect_point(world.obstacles()[0].attachment->X_TO.translation(), {0, 0, -0.1}, 1e-12);
  for (int i = 1; i <= 10; ++i) {
    put_arm(world, 0, at_point(0.5 + 0.01 * i, 0, 0.6));
    world.step(0.01);
  }
  expect_point(place(world), {0.6, 0, 0.5}, 1e-9);
  expect_point(world.snapshot().states[0].velocity.linear, {1.0, 0, 0}, 1e-9);
  // Turned upside down about the tool, between steps: at once.
  put_arm(world, 0, pose_from_xyz_rpy({0.6, 0, 0.6}, {kPi, 0, 0}));
  expect_point(place(world), {0.6, 0, 0.7}, 1e-9);
  EXPECT_EQ(world.referee().report().contacts, 0U) << "the hand may touch what it holds";
  // What it carries counts as the arm: arm2 comes within 0.05 m of the box.
  put_arm(world, 1, at_point(0.75, 0, 0.7));
  world.step(0.01);
  const RefereeReport report = world.referee().report();
  EXPECT_EQ(report.smallest.kind, ContactKind::kArmArm);
  EXPECT_NEAR(report.smallest.distance, 0.05, 1e-6);
}

TEST(BulletWorld, ATurningToolGivesItsVelocityToWhatItCarries) {
  BulletWorld world = world_of({thing("box", Sphere{0.05}, at_point(1.0, 0, 0.5))}, {box_arm("arm1")});
  put_arm(world, 0, at_point(0, 0, 0.5));
  world.step(0.01);
  ASSERT_TRUE(world.attach("box", "arm1").done);
  // 0.01 rad in 10 ms about z, 1 m from the axis: 1 rad/s, 1 m/s along y, to the first order.
  put_arm(world, 0, pose_from_xyz_rpy({0, 0, 0.5}, {0, 0, 0.01}));
  world.step(0.01);
  const Twist velocity = world.snapshot().states[0].velocity;
  expect_point(velocity.angular, {0, 0, 1.0}, 1e-9);
  expect_point(velocity.linear, {-std::sin(0.01), std::cos(0.01), 0}, 1e-9);
}

TEST(BulletWorld, DetachedBodiesFallOthersStay) {
  BulletWorld world = world_of({thing("ball", Sphere{0.05}, at_point(0.5, 0, 1.0), falling()),
                                thing("sign", Sphere{0.05}, at_point(0.5, 1, 1.0), SineMotion{})},
                               {box_arm("arm1")});
  put_arm(world, 0, at_point(0.5, 0.5, 1.0));
  ASSERT_TRUE(world.attach("ball", "arm1").done);
  ASSERT_TRUE(world.attach("sign", "arm1").done);
  for (int i = 1; i <= 50; ++i) {
    put_arm(world, 0, at_point(0.5 + 0.01 * i, 0.5, 1.0));
    world.step(0.01);
  }
  expect_point(place(world, 0), {1.0, 0, 1.0}, 1e-9);
  ASSERT_TRUE(world.detach("ball").done);
  ASSERT_TRUE(world.detach("sign").done);
  const Vector3d sign = place(world, 1);
  for (int i = 0; i < 20; ++i) world.step(0.01);
  expect_point(place(world, 1), sign, 1e-12);
  EXPECT_EQ(world.snapshot().states[1].velocity.linear.norm(), 0.0);
  // Let go at 1 m/s: 0.2 m further and ½ g 0.2² lower, symplectic Euler ahead by ½ g h t = 4.9 mm.
  expect_point(place(world, 0), {1.2, 0, 1.0 - 0.5 * kGravity * 0.04}, 0.006);
}

TEST(BulletWorld, RefusalsSayWhyAndChangeNothing) {
  Obstacle held = thing("held", Sphere{0.05}, at_point(0, 0, 2));
  held.attachment = Attachment{"arm2", Pose::Identity()};
  BulletWorld world =
      world_of({thing("post", Sphere{0.1}, at_point(0, 0, 1)), held}, {box_arm("arm1"), box_arm("arm2")});
  put_arm(world, 0, at_point(3, 0, 0));
  world.step(0.01);
  const ObstacleSnapshot before = world.snapshot();

  const auto expect_refused = [&](const EditResult& result, const std::string& reason) {
    EXPECT_FALSE(result.done);
    EXPECT_EQ(result.reason, reason);
  };
  expect_refused(world.add(thing("post", Sphere{0.1}, at_point(0, 0, 5))), "there is already an obstacle named 'post'");
  expect_refused(world.add(thing("pin", Sphere{0.0}, at_point(0, 0, 5))),
                 "obstacle 'pin': sphere radius = 0 must be finite and > 0");
  Obstacle lost = thing("pin", Sphere{0.1}, at_point(0, 0, 5));
  lost.attachment = Attachment{"arm9", Pose::Identity()};
  expect_refused(world.add(lost), "obstacle 'pin' is attached to 'arm9', which is no arm of this cell");
  expect_refused(world.move("pin", at_point(0, 0, 0)), "there is no obstacle named 'pin'");
  expect_refused(world.move("held", at_point(0, 0, 0)), "obstacle 'held' is attached to 'arm2': detach it first");
  expect_refused(world.move("post", at_point(0, 0, std::numeric_limits<double>::quiet_NaN())),
                 "obstacle 'post' cannot be moved to what is no finite, rigid pose");
  expect_refused(world.remove("pin"), "there is no obstacle named 'pin'");
  expect_refused(world.attach("pin", "arm1"), "there is no obstacle named 'pin'");
  expect_refused(world.attach("post", "arm9"), "there is no arm named 'arm9'");
  expect_refused(world.attach("post", "arm2"), "where arm 'arm2' is was never measured");
  expect_refused(world.attach("held", "arm1"), "obstacle 'held' is already attached to 'arm2'");
  expect_refused(world.detach("pin"), "there is no obstacle named 'pin'");
  expect_refused(world.detach("post"), "obstacle 'post' is not attached to any arm");
  expect_refused(world.detach("held"), "where arm 'arm2', which carries 'held', is was never measured");

  const ObstacleSnapshot after = world.snapshot();
  EXPECT_EQ(after.edition, before.edition);
  ASSERT_EQ(after.states.size(), before.states.size());
  for (std::size_t i = 0; i < after.states.size(); ++i) {
    EXPECT_TRUE(after.states[i].X_WO.matrix() == before.states[i].X_WO.matrix());
  }
  EXPECT_EQ(world.obstacles().size(), 2U);
}

/// A busy world: bodies that collide, scripts, an arm that pushes, edits on the way.
ObstacleSnapshot play() {
  BulletWorld world = world_of({thing("box1", Box{Vector3d(0.1, 0.1, 0.1)}, at_point(0, 0, 0.5), falling(0.3)),
                                thing("box2", Box{Vector3d(0.1, 0.1, 0.1)}, at_point(0.05, 0.02, 0.9), falling(0.3)),
                                thing("ball", Sphere{0.1}, at_point(0.02, 0.05, 1.3), falling(0.5)),
                                thing("can", Cylinder{0.08, 0.1}, at_point(0.3, 0, 0.4), falling()),
                                thing("pusher", Box{Vector3d(0.1, 0.3, 0.1)}, at_point(-0.8, 0, 0.15),
                                      SineMotion{Vector3d::UnitX(), 0.6, 3.0, 0})},
                               {box_arm("arm1")});
  for (int i = 0; i < 1000; ++i) {
    put_arm(world, 0, at_point(0.5 * std::sin(0.01 * i), 0.3 * std::cos(0.013 * i), 0.1));
    if (i == 200) {
      EXPECT_TRUE(world.add(thing("late", Capsule{0.05, 0.1}, at_point(0, 0, 1.0), falling())).done);
    }
    if (i == 400) {
      EXPECT_TRUE(world.attach("can", "arm1").done);
    }
    if (i == 500) {
      EXPECT_TRUE(world.detach("can").done);
    }
    if (i == 600) {
      EXPECT_TRUE(world.remove("box1").done);
    }
    if (i == 700) {
      EXPECT_TRUE(world.move("ball", at_point(0, 0, 1)).done);
    }
    world.step(0.01);
  }
  EXPECT_GT(world.referee().report().contacts, 0U);
  return world.snapshot();
}

bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  return std::equal(a.data(), a.data() + a.size(), b.data(), b.data() + b.size(),
                    [&](double x, double y) { return bits(x) == bits(y); });
}

TEST(BulletWorld, SameCallsGiveTheSameBits) {
  const ObstacleSnapshot first = play();
  const ObstacleSnapshot second = play();
  ASSERT_EQ(first.states.size(), second.states.size());
  EXPECT_EQ(first.sequence, 1000U);
  for (std::size_t i = 0; i < first.states.size(); ++i) {
    const ObstacleState& a = first.states[i];
    const ObstacleState& b = second.states[i];
    EXPECT_TRUE(a.X_WO.matrix().allFinite());
    EXPECT_TRUE(same_bits(a.X_WO.matrix(), b.X_WO.matrix())) << i;
    EXPECT_TRUE(same_bits(a.velocity.linear, b.velocity.linear)) << i;
    EXPECT_TRUE(same_bits(a.velocity.angular, b.velocity.angular)) << i;
  }
}

TEST(BulletWorld, EqualWorldsDoNotDisturbEachOther) {
  // Two worlds stepped in turns end as one stepped alone.
  const auto make = [] {
    return world_of(
        {thing("box", Box{Vector3d(0.1, 0.1, 0.1)}, pose_from_xyz_rpy({0, 0, 0.5}, {0.3, 0.2, 0}), falling(0.4))});
  };
  BulletWorld alone = make();
  for (int i = 0; i < 300; ++i) alone.step(0.01);
  BulletWorld a = make();
  BulletWorld b = make();
  for (int i = 0; i < 300; ++i) {
    a.step(0.01);
    b.step(0.01);
  }
  EXPECT_TRUE(place(a) == place(alone));
  EXPECT_TRUE(place(b) == place(alone));
}

}  // namespace
}  // namespace hecaton::world
