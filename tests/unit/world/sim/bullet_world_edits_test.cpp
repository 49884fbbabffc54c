// Edits of a running world: move, remove, attach, detach, and refusals.
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/sim/small_worlds.hpp"

namespace hecaton::world {
namespace {

using Eigen::Vector3d;

TEST(BulletWorldEdits, MoveEndsScriptedMotionAndStopsFall) {
  BulletWorld world =
      world_of({thing("belt", Sphere{0.1}, at_point(5, 0, 0), ConveyorMotion{Vector3d::UnitX(), 0.5, 2.0}),
                thing("ball", Sphere{0.1}, at_point(0, 0, 2), falling())});
  for (int i = 0; i < 20; ++i) world.step(0.01);
  EXPECT_TRUE(world.move("belt", at_point(7, 0, 0)).done());
  EXPECT_TRUE(world.move("ball", at_point(0, 0, 1.1)).done());
  EXPECT_EQ(world.snapshot().states[1].velocity.linear.norm(), 0.0);
  for (int i = 0; i < 10; ++i) world.step(0.01);
  expect_point(place(world, 0), {7, 0, 0}, 1e-12);
  EXPECT_EQ(world.snapshot().states[0].velocity.linear.norm(), 0.0);
  // Falls again, from rest: ½ g 0.1².
  EXPECT_NEAR(place(world, 1).z(), 1.1 - 0.5 * kGravity * 0.01, 0.003);
  ASSERT_TRUE(std::holds_alternative<DynamicMotion>(world.obstacles()[1].motion));
}

TEST(BulletWorldEdits, BodyFallsWhenItsSupportIsRemoved) {
  BulletWorld world = world_of({thing("table", Box{Vector3d(0.3, 0.3, 0.1)}, at_point(0, 0, 0.9)),
                                thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0, 0, 1.05), falling())});
  for (int i = 0; i < 500; ++i) world.step(0.01);
  EXPECT_NEAR(place(world, 1).z(), 1.05, 2e-3);
  EXPECT_TRUE(world.remove("table").done());
  for (int i = 0; i < 200; ++i) world.step(0.01);
  EXPECT_NEAR(place(world, 0).z(), 0.05, 2e-3);
}

TEST(BulletWorldEdits, StackStandsStill) {
  const Box cube{Vector3d(0.1, 0.1, 0.1)};
  BulletWorld world = world_of({thing("low", cube, at_point(0, 0, 0.1), falling()),
                                thing("middle", cube, at_point(0, 0, 0.3), falling()),
                                thing("top", cube, at_point(0, 0, 0.5), falling())});
  for (int i = 0; i < 1000; ++i) world.step(0.01);
  for (int i = 0; i < 3; ++i) expect_point(place(world, i), {0, 0, 0.1 + 0.2 * i}, 5e-3);
}

TEST(BulletWorldEdits, AttachedObstaclesFollowTheTool) {
  BulletWorld world = world_of({thing("box", Box{Vector3d(0.05, 0.05, 0.05)}, at_point(0.5, 0, 0.5), falling())},
                               {box_arm("arm1"), box_arm("arm2")});
  put_arm(world, 0, at_point(0.5, 0, 0.6));
  put_arm(world, 1, at_point(9, 0, 0.6));
  ASSERT_TRUE(world.attach("box", "arm1").done());
  ASSERT_TRUE(world.obstacles()[0].attachment.has_value());
  expect_point(world.obstacles()[0].attachment->X_TO.translation(), {0, 0, -0.1}, 1e-12);
  for (int i = 1; i <= 10; ++i) {
    put_arm(world, 0, at_point(0.5 + 0.01 * i, 0, 0.6));
    world.step(0.01);
  }
  expect_point(place(world), {0.6, 0, 0.5}, 1e-9);
  expect_point(world.snapshot().states[0].velocity.linear, {1.0, 0, 0}, 1e-9);
  // Turned upside down about the tool, between steps: at once.
  put_arm(world, 0, pose_from_xyz_rpy({0.6, 0, 0.6}, {std::numbers::pi, 0, 0}));
  expect_point(place(world), {0.6, 0, 0.7}, 1e-9);
  EXPECT_EQ(world.contact_monitor().report().contacts, 0U) << "a grasp link may touch the attached obstacle";
  // An attached obstacle is part of the arm: arm2 comes within 0.05 m of the box.
  put_arm(world, 1, at_point(0.75, 0, 0.7));
  world.step(0.01);
  const ContactReport report = world.contact_monitor().report();
  EXPECT_EQ(report.smallest.kind, ContactKind::kArmArm);
  EXPECT_NEAR(report.smallest.distance, 0.05, 1e-6);
}

TEST(BulletWorldEdits, AttachedObstacleHasVelocityOfTurningTool) {
  BulletWorld world = world_of({thing("box", Sphere{0.05}, at_point(1.0, 0, 0.5))}, {box_arm("arm1")});
  put_arm(world, 0, at_point(0, 0, 0.5));
  world.step(0.01);
  ASSERT_TRUE(world.attach("box", "arm1").done());
  // 0.01 rad in 10 ms about z, 1 m from the axis: 1 rad/s, 1 m/s along y, to the first order.
  put_arm(world, 0, pose_from_xyz_rpy({0, 0, 0.5}, {0, 0, 0.01}));
  world.step(0.01);
  const Twist velocity = world.snapshot().states[0].velocity;
  expect_point(velocity.angular, {0, 0, 1.0}, 1e-9);
  expect_point(velocity.linear, {-std::sin(0.01), std::cos(0.01), 0}, 1e-9);
}

TEST(BulletWorldEdits, DetachedBodiesFallOthersStay) {
  BulletWorld world = world_of({thing("ball", Sphere{0.05}, at_point(0.5, 0, 1.0), falling()),
                                thing("sign", Sphere{0.05}, at_point(0.5, 1, 1.0), SineMotion{})},
                               {box_arm("arm1")});
  put_arm(world, 0, at_point(0.5, 0.5, 1.0));
  ASSERT_TRUE(world.attach("ball", "arm1").done());
  ASSERT_TRUE(world.attach("sign", "arm1").done());
  for (int i = 1; i <= 50; ++i) {
    put_arm(world, 0, at_point(0.5 + 0.01 * i, 0.5, 1.0));
    world.step(0.01);
  }
  expect_point(place(world, 0), {1.0, 0, 1.0}, 1e-9);
  ASSERT_TRUE(world.detach("ball").done());
  ASSERT_TRUE(world.detach("sign").done());
  const Vector3d sign = place(world, 1);
  for (int i = 0; i < 20; ++i) world.step(0.01);
  expect_point(place(world, 1), sign, 1e-12);
  EXPECT_EQ(world.snapshot().states[1].velocity.linear.norm(), 0.0);
  // Detached at 1 m/s: 0.2 m further and ½ g 0.2² lower, symplectic Euler ahead by ½ g h t = 4.9 mm.
  expect_point(place(world, 0), {1.2, 0, 1.0 - 0.5 * kGravity * 0.04}, 0.006);
}

TEST(BulletWorldEdits, RefusedEditGivesReasonAndChangesNothing) {
  Obstacle held = thing("held", Sphere{0.05}, at_point(0, 0, 2));
  held.attachment = Attachment{"arm2", Pose::Identity()};
  BulletWorld world =
      world_of({thing("post", Sphere{0.1}, at_point(0, 0, 1)), held}, {box_arm("arm1"), box_arm("arm2")});
  put_arm(world, 0, at_point(3, 0, 0));
  world.step(0.01);
  const ObstacleSnapshot before = world.snapshot();

  const auto expect_refused = [&](const EditResult& result, const std::string& reason) {
    EXPECT_FALSE(result.done());
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
                 "obstacle 'post' cannot be moved: the pose must be finite and rigid");
  expect_refused(world.remove("pin"), "there is no obstacle named 'pin'");
  expect_refused(world.attach("pin", "arm1"), "there is no obstacle named 'pin'");
  expect_refused(world.attach("post", "arm9"), "there is no arm named 'arm9'");
  expect_refused(world.attach("post", "arm2"), "arm 'arm2' has not reported its position yet");
  expect_refused(world.attach("held", "arm1"), "obstacle 'held' is already attached to 'arm2'");
  expect_refused(world.detach("pin"), "there is no obstacle named 'pin'");
  expect_refused(world.detach("post"), "obstacle 'post' is not attached to any arm");
  expect_refused(world.detach("held"), "arm 'arm2', which carries 'held', has not reported its position yet");

  const ObstacleSnapshot after = world.snapshot();
  EXPECT_EQ(after.edition, before.edition);
  ASSERT_EQ(after.states.size(), before.states.size());
  for (std::size_t i = 0; i < after.states.size(); ++i) {
    EXPECT_TRUE(after.states[i].X_WO.matrix() == before.states[i].X_WO.matrix());
  }
  EXPECT_EQ(world.obstacles().size(), 2U);
}

}  // namespace
}  // namespace hecaton::world
