#include "world/sim/bullet_world.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/unit/world/sim/small_worlds.hpp"

namespace hecaton::world {
namespace {

using Eigen::Vector3d;

TEST(BulletWorld, ScriptedMotionsFollowWorldTime) {
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
  EXPECT_TRUE(world.move("post", at_point(0, 2, 0)).done());
  EXPECT_EQ(world.snapshot().edition, edition);
  EXPECT_TRUE(world.add(thing("crate", Sphere{0.1}, at_point(0, 3, 0))).done());
  EXPECT_EQ(world.snapshot().edition, edition + 1);
  EXPECT_TRUE(world.remove("post").done());
  EXPECT_EQ(world.snapshot().edition, edition + 2);
  ASSERT_EQ(world.snapshot().states.size(), 1U);
  expect_point(place(world), {0, 3, 0}, 1e-12);
}

TEST(BulletWorld, BodyFallsWithGravity) {
  BulletWorld world = world_of({thing("ball", Sphere{0.1}, at_point(0, 0, 2.1), falling())});
  // Half a second: ½ g t² = 1.226 m. Symplectic Euler is ahead by ½ g h t ≤ 12.3 mm at 5 ms.
  for (int i = 0; i < 100; ++i) world.step(0.005);
  EXPECT_NEAR(place(world).z(), 2.1 - 0.5 * kGravity * 0.25, 0.013);
  EXPECT_NEAR(world.snapshot().states[0].velocity.linear.z(), -kGravity * 0.5, 1e-9);
}

TEST(BulletWorld, BodyLandsOnTimeAndRests) {
  BulletWorld world = world_of({thing("box", Box{Vector3d(0.1, 0.1, 0.1)}, at_point(0, 0, 1.1), falling())});
  // 1 m of free fall takes √(2/g) = 0.4515 s.
  while (place(world).z() > 0.105 && world.time() < 2.0) world.step(0.005);
  EXPECT_NEAR(world.time(), std::sqrt(2.0 / kGravity), 0.011);
  for (int i = 0; i < 400; ++i) world.step(0.005);
  expect_point(place(world), {0, 0, 0.1}, 2e-3);
  EXPECT_LT(world.snapshot().states[0].velocity.linear.norm(), 1e-2);
  EXPECT_LT(world.snapshot().states[0].velocity.angular.norm(), 1e-2);
}

TEST(BulletWorld, EachShapeRestsOnTheFloorAtItsHeight) {
  auto wedge = std::make_shared<ConvexHull>();
  // A prism 0.4 × 0.4 at the bottom, 0.2 high, its vertices far from its own origin.
  wedge->vertices = {{1, 1, 1}, {1.4, 1, 1}, {1.4, 1.4, 1}, {1, 1.4, 1}, {1.2, 1.1, 1.2}, {1.2, 1.3, 1.2}};
  wedge->faces = {{0, 3, 2, 1}, {0, 1, 4}, {2, 3, 5}, {1, 2, 5, 4}, {3, 0, 4, 5}};
  const Pose lying = pose_from_xyz_rpy({4, 0, 0.5}, {std::numbers::pi / 2, 0, 0});
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

TEST(BulletWorld, BodyLandsOnFloorAtGivenHeight) {
  Scene scene;
  scene.floor_z = -0.5;
  scene.obstacles = {thing("ball", Sphere{0.1}, at_point(0, 0, 0), falling())};
  BulletWorld world(scene, {});
  for (int i = 0; i < 600; ++i) world.step(0.005);
  EXPECT_NEAR(place(world).z(), -0.4, 2e-3);
}

TEST(BulletWorld, SlidingBallRollsAtFiveSeventhsOfItsSpeed) {
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

TEST(BulletWorld, ArmPushesABodyAndTheContactIsReported) {
  BulletWorld world =
      world_of({thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0.3, 0, 0.05), falling())}, {box_arm("arm1")});
  // 0.2 m/s along x for 2 s, from 0.2 m of clearance: touching after 1 s, then 0.2 m of push.
  for (int i = 0; i <= 200; ++i) {
    ASSERT_TRUE(put_arm(world, 0, at_point(0.002 * i, 0, 0.06)));
    world.step(0.01);
  }
  EXPECT_NEAR(place(world).x(), 0.5, 0.02);
  EXPECT_NEAR(world.snapshot().states[0].velocity.linear.x(), 0.2, 0.05);
  const ContactReport report = world.contact_monitor().report();
  EXPECT_GE(report.kinds[static_cast<std::size_t>(ContactKind::kArmObstacle)].contacts, 1U);
  EXPECT_GT(report.smallest.distance, -0.01);
}

TEST(BulletWorld, ScriptedObstaclePushesBody) {
  BulletWorld world = world_of({thing("pusher", Box{Vector3d(0.05, 0.2, 0.05)}, at_point(0, 0, 0.06),
                                      ConveyorMotion{Vector3d::UnitX(), 0.2, 10}),
                                thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0.2, 0, 0.05), falling())});
  for (int i = 0; i < 200; ++i) world.step(0.01);
  // After 2 s the pusher's face is at 0.45.
  EXPECT_NEAR(place(world, 1).x(), 0.5, 0.02);
}

TEST(BulletWorld, BodyRidesOnMovingTray) {
  DynamicMotion motion = falling();
  motion.friction = 0.8;
  BulletWorld world = world_of(
      {thing("tray", Box{Vector3d(0.5, 0.5, 0.02)}, at_point(0, 0, 0.5), SineMotion{Vector3d::UnitX(), 0.2, 4.0, 0.0}),
       thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0, 0, 0.57), motion)});
  // The script starts with 0.31 m/s: the box slides once, then rides along. 0.2 (2π/4)² = 0.49 m/s² is well below μ g.
  for (int i = 0; i < 100; ++i) world.step(0.01);
  const double offset = place(world, 1).x() - place(world, 0).x();
  for (int i = 0; i < 300; ++i) world.step(0.01);
  EXPECT_NEAR(place(world, 1).x() - place(world, 0).x(), offset, 0.01);
  EXPECT_NEAR(place(world, 1).z(), 0.57, 3e-3);
}

TEST(BulletWorld, ConveyorRestartDoesNotAccelerateBodies) {
  // The belt jumps back beneath a box that lies beside it; with the jump taken for a velocity of 100 m/s the box flies.
  BulletWorld world = world_of(
      {thing("belt", Box{Vector3d(0.2, 0.2, 0.05)}, at_point(0, 0, 0.05), ConveyorMotion{Vector3d::UnitX(), 0.5, 0.5}),
       thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0.1, 0, 0.152), falling())});
  for (int i = 0; i < 500; ++i) {
    world.step(0.01);
    ASSERT_LT(world.snapshot().states[1].velocity.linear.norm(), 2.0) << "at " << world.time();
  }
}

/// Number of the last change of an obstacle's pose.
std::uint64_t change(const BulletWorld& world, int obstacle) {
  return world.present().changes[static_cast<std::size_t>(obstacle)];
}

/// A box of 0.1 m that has slept on a table at 0.5 m.
BulletWorld sleeping_on_table(std::vector<ArmBodies> arms = {}, Obstacle more = {}) {
  std::vector<Obstacle> obstacles{thing("box", Box{{0.05, 0.05, 0.05}}, at_point(0, 0, 0.551), falling()),
                                  thing("table", Box{{0.3, 0.3, 0.05}}, at_point(0, 0, 0.45))};
  if (!more.name.empty()) obstacles.push_back(std::move(more));
  BulletWorld world = world_of(obstacles, std::move(arms));
  for (int i = 0; i < 400; ++i) world.step(0.01);
  const std::uint64_t before = change(world, 0);
  for (int i = 0; i < 10; ++i) world.step(0.01);
  EXPECT_EQ(change(world, 0), before) << "the box is awake";
  return world;
}

TEST(BulletWorld, SleepingBodyFallsWhenItsSupportMovesOrGoes) {
  BulletWorld moved = sleeping_on_table();
  ASSERT_TRUE(moved.move("table", at_point(5, 0, 0.45)).done());
  for (int i = 0; i < 20; ++i) moved.step(0.01);
  EXPECT_NEAR(place(moved).z(), 0.55 - 0.5 * kGravity * 0.04, 0.02);
  BulletWorld removed = sleeping_on_table();
  ASSERT_TRUE(removed.remove("table").done());
  for (int i = 0; i < 20; ++i) removed.step(0.01);
  EXPECT_NEAR(place(removed).z(), 0.55 - 0.5 * kGravity * 0.04, 0.02);
}

TEST(BulletWorld, SleepingBodyIsPushedByAnArmAndByAFallingBody) {
  BulletWorld pushed = sleeping_on_table({box_arm("arm1")});
  for (int i = 0; i <= 100; ++i) {
    ASSERT_TRUE(put_arm(pushed, 0, at_point(-0.3 + 0.003 * i, 0, 0.56)));
    pushed.step(0.01);
  }
  EXPECT_GT(place(pushed).x(), 0.05);
  BulletWorld hit = sleeping_on_table();
  DynamicMotion thrown = falling();
  thrown.initial_velocity.linear = Eigen::Vector3d(2, 0, 0);
  ASSERT_TRUE(hit.add(thing("ball", Sphere{0.05}, at_point(-0.2, 0, 0.56), thrown)).done());
  for (int i = 0; i < 30; ++i) hit.step(0.01);
  EXPECT_GT(place(hit).x(), 0.01);
}

TEST(BulletWorld, BodyOnMovingSupportStaysAwake) {
  BulletWorld world = world_of({thing("box", Box{{0.05, 0.05, 0.05}}, at_point(0, 0, 0.55), falling()),
                                thing("lift", Box{{0.3, 0.3, 0.05}}, at_point(0, 0, 0.45),
                                      SineMotion{Eigen::Vector3d::UnitZ(), 0.0005, 20.0, 0.0})});
  for (int i = 0; i < 1000; ++i) world.step(0.01);
  const std::uint64_t before = change(world, 0);
  world.step(0.01);
  EXPECT_NE(change(world, 0), before);
  EXPECT_NEAR(place(world).z(), place(world, 1).z() + 0.1, 0.002);
}

TEST(BulletWorld, FastSmallBodyStopsAtThinPlate) {
  for (const double speed : {1.0, 5.0, 10.0, 15.0}) {
    DynamicMotion thrown = falling();
    thrown.initial_velocity.linear = Eigen::Vector3d(speed, 0, 0);
    // 15 m/s are 75 mm in a substep of 5 ms.
    BulletWorld world = world_of({thing("ball", Sphere{0.01}, at_point(-0.55, 0, 1.5), thrown),
                                  thing("plate", Box{{0.003, 1.0, 1.5}}, at_point(0, 0, 1.5))});
    for (int i = 0; i < 60; ++i) world.step(0.01);
    EXPECT_LT(place(world).x(), -0.003) << speed << " m/s";
  }
}

TEST(BulletWorld, UnknownArmsPushNothing) {
  BulletWorld world =
      world_of({thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0, 0, 0.05), falling())}, {box_arm("arm1")});
  for (int i = 0; i < 50; ++i) world.step(0.01);
  expect_point(place(world), {0, 0, 0.05}, 2e-3);
  EXPECT_FALSE(world.contact_monitor().report().has_smallest);
}

TEST(BulletWorld, IgnoresInvalidMeasurements) {
  BulletWorld world = world_of({thing("post", Sphere{0.1}, at_point(0, 0, 1))}, {box_arm("arm1")});
  EXPECT_FALSE(put_arm(world, 1, at_point(0, 0, 0)));
  EXPECT_FALSE(put_arm(world, -1, at_point(0, 0, 0)));
  EXPECT_FALSE(world.set_arm(0, {}, at_point(0, 0, 0)));
  EXPECT_FALSE(put_arm(world, 0, at_point(0, std::numeric_limits<double>::quiet_NaN(), 0)));
  world.step(0.01);
  EXPECT_FALSE(world.contact_monitor().report().has_smallest);
  EXPECT_TRUE(put_arm(world, 0, at_point(0, 0, 0)));
  world.step(0.01);
  EXPECT_TRUE(world.contact_monitor().report().has_smallest);
}

TEST(BulletWorld, ThrowsOnInvalidSteps) {
  BulletWorld world = world_of({});
  EXPECT_THROW(world.step(-0.01), std::invalid_argument);
  EXPECT_THROW(world.step(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(world.set_time(std::numeric_limits<double>::infinity()), std::invalid_argument);
  EXPECT_NO_THROW(world.step(0.0));
}

TEST(BulletWorld, ThrowsOnInvalidScenes) {
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
      EXPECT_TRUE(world.add(thing("late", Capsule{0.05, 0.1}, at_point(0, 0, 1.0), falling())).done());
    }
    if (i == 400) {
      EXPECT_TRUE(world.attach("can", "arm1").done());
    }
    if (i == 500) {
      EXPECT_TRUE(world.detach("can").done());
    }
    if (i == 600) {
      EXPECT_TRUE(world.remove("box1").done());
    }
    if (i == 700) {
      EXPECT_TRUE(world.move("ball", at_point(0, 0, 1)).done());
    }
    world.step(0.01);
  }
  EXPECT_GT(world.contact_monitor().report().contacts, 0U);
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

TEST(BulletWorld, WorldsAreIndependent) {
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
