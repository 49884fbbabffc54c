#include "services/world/world_memory.hpp"

#include <filesystem>
#include <numbers>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "services/bus/message_file.hpp"
#include "services/world/memory_keeper.hpp"

namespace hecaton::services {
namespace {

using Eigen::Vector3d;

world::Pose at_point(double x, double y, double z) {
  world::Pose pose = world::Pose::Identity();
  pose.translation() = Vector3d(x, y, z);
  return pose;
}

world::Obstacle ball(const std::string& name, const world::Pose& X_WO, world::Motion motion = world::StaticMotion{}) {
  world::Obstacle obstacle;
  obstacle.name = name;
  obstacle.shapes.push_back({world::Sphere{0.1}});
  obstacle.X_WO = X_WO;
  obstacle.motion = std::move(motion);
  return obstacle;
}

/// One arm of one ball of radius 0.1 m at its tool.
std::vector<world::ArmBodies> ball_arm() {
  world::ArmBodies arm;
  arm.name = "arm";
  arm.parts.push_back({0, "hand", {world::Sphere{0.1}, world::Pose::Identity()}, true});
  return {arm};
}

void put(world::BulletWorld& world, const world::Pose& X_WT) {
  ASSERT_TRUE(world.set_arm(0, std::span(&X_WT, 1), X_WT));
}

/// The world that goes on where `memory` ends.
world::BulletWorld successor(const msg::WorldMemory& memory) {
  const auto next = continuation(memory, world::Scene{});
  EXPECT_TRUE(next) << next.error;
  world::BulletWorld world(next->scene, ball_arm());
  world.go_on(next->time, next->edition, next->account);
  return world;
}

TEST(WorldMemory, EditsMotionsAndTimeGoOn) {
  world::Scene scene;
  // Half a turn takes π s at 1 rad/s: from x = 1 to x = −1 about the origin.
  scene.obstacles = {ball("moon", at_point(1, 0, 0), world::CircleMotion{Vector3d::Zero(), Vector3d::UnitZ(), 1.0}),
                     ball("rock", at_point(5, 0, 0)), ball("gone", at_point(6, 0, 0))};
  world::BulletWorld first(scene, ball_arm());
  ASSERT_TRUE(first.add(ball("crate", at_point(2, 3, 4))).done);
  ASSERT_TRUE(first.move("rock", at_point(5, 1, 0)).done);
  ASSERT_TRUE(first.remove("gone").done);
  first.step(1.0);

  world::BulletWorld second = successor(memory_of(first));
  EXPECT_EQ(second.time(), first.time());
  EXPECT_EQ(second.snapshot().edition, first.snapshot().edition);
  second.step(std::numbers::pi - 1.0);
  ASSERT_EQ(second.obstacles().size(), 3U);
  EXPECT_EQ(second.obstacles()[2].name, "crate");
  const auto states = second.snapshot().states;
  EXPECT_LT((states[0].X_WO.translation() - Vector3d(-1, 0, 0)).norm(), 1e-9);
  EXPECT_LT((states[1].X_WO.translation() - Vector3d(5, 1, 0)).norm(), 1e-12);
  EXPECT_LT((states[2].X_WO.translation() - Vector3d(2, 3, 4)).norm(), 1e-12);
}

TEST(WorldMemory, WhatFallsGoesOnFalling) {
  world::Scene scene;
  world::DynamicMotion motion;
  scene.obstacles = {ball("stone", at_point(0, 0, 10), motion)};
  world::BulletWorld first(scene, ball_arm());
  first.step(0.5);
  world::BulletWorld second = successor(memory_of(first));
  EXPECT_LT((second.snapshot().states[0].X_WO.translation() - first.snapshot().states[0].X_WO.translation()).norm(),
            1e-12);
  first.step(0.25);
  second.step(0.25);
  EXPECT_LT((second.snapshot().states[0].X_WO.translation() - first.snapshot().states[0].X_WO.translation()).norm(),
            1e-6);
}

TEST(WorldMemory, WhatIsCarriedStaysInTheHand) {
  world::Scene scene;
  scene.obstacles = {ball("box", at_point(0, 0, 0.5))};
  world::BulletWorld first(scene, ball_arm());
  put(first, at_point(0, 0, 0));
  first.step(0.01);
  ASSERT_TRUE(first.attach("box", "arm").done);
  put(first, at_point(1, 0, 0));
  first.step(0.01);

  world::BulletWorld second = successor(memory_of(first));
  EXPECT_EQ(second.snapshot().states[0].X_WO.translation(), Vector3d(1, 0, 0.5)) << "also before the arm is heard";
  put(second, at_point(2, 0, 0));
  second.step(0.01);
  EXPECT_EQ(second.snapshot().states[0].X_WO.translation(), Vector3d(2, 0, 0.5));
}

TEST(WorldMemory, AContactThatLastsCountsOnce) {
  world::Scene scene;
  scene.obstacles = {ball("post", at_point(0, 0, 0))};
  world::BulletWorld first(scene, ball_arm());
  put(first, at_point(0.15, 0, 0));  // 5 cm deep
  first.step(0.01);
  ASSERT_EQ(first.referee().report().contacts, 1U);

  world::BulletWorld second = successor(memory_of(first));
  EXPECT_EQ(second.referee().report().contacts, 1U);
  EXPECT_NEAR(second.referee().report().smallest.distance, -0.05, 1e-4);
  ASSERT_EQ(second.referee().report().events.size(), 1U);
  EXPECT_EQ(second.referee().report().events[0].b, "post");
  put(second, at_point(0.15, 0, 0));
  second.step(0.01);
  EXPECT_EQ(second.referee().report().contacts, 1U);
  for (const double x : {0.5, 0.15}) {
    put(second, at_point(x, 0, 0));
    second.step(0.01);
  }
  EXPECT_EQ(second.referee().report().contacts, 2U) << "it had parted and touched again";
}

TEST(WorldMemory, WhatLayBesideWhenItWasGraspedStaysExcused) {
  world::Scene scene;
  scene.obstacles = {ball("box", at_point(0, 0, 1)), ball("table", at_point(0, 0, 0.85))};  // 5 cm deep in it
  world::BulletWorld first(scene, ball_arm());
  put(first, at_point(0, 0, 1.5));
  first.step(0.01);
  ASSERT_TRUE(first.attach("box", "arm").done);
  for (const bool judged_before : {false, true}) {
    if (judged_before) first.step(0.01);
    world::BulletWorld second = successor(memory_of(first));
    put(second, at_point(0, 0, 1.5));
    second.step(0.01);
    EXPECT_EQ(second.referee().report().contacts, 0U) << judged_before;
  }
}

TEST(WorldMemory, WhatCannotBeIsRefusedWithASentence) {
  msg::WorldMemory memory = memory_of(world::BulletWorld(world::Scene{{ball("a", at_point(0, 0, 0))}}, ball_arm()));
  memory.obstacles()[0].shapes()[0].dimensions().x(-1.0);
  EXPECT_NE(continuation(memory, world::Scene{}).error.find("a"), std::string::npos);
  memory.obstacles().clear();
  memory.referee().kinds().clear();
  EXPECT_EQ(continuation(memory, world::Scene{}).error, "referee: another number of kinds of contacts");
}

class Keeper : public ::testing::Test {
 protected:
  ~Keeper() override { std::filesystem::remove(path_); }
  static msg::WorldMemory memory(double time) {
    msg::WorldMemory message;
    message.time(time);
    return message;
  }
  static void await(const MemoryKeeper& keeper, std::uint64_t number) {
    while (!keeper.kept(number)) std::this_thread::yield();
  }
  std::string path_ =
      (std::filesystem::temp_directory_path() / ("memory_keeper_test-" + std::to_string(getpid()))).string();
};

TEST_F(Keeper, WritesTheNewest) {
  MemoryKeeper keeper(path_);
  std::uint64_t last = 0;
  for (int i = 1; i <= 100; ++i) last = keeper.keep(memory(i));
  await(keeper, last);
  EXPECT_EQ(bus::read_message(path_).message->time(), 100.0);
  EXPECT_EQ(keeper.failure(), "");
}

TEST_F(Keeper, WritesWhatIsLeftWhenItEnds) {
  { static_cast<void>(MemoryKeeper(path_).keep(memory(7))); }
  EXPECT_EQ(bus::read_message(path_).message->time(), 7.0);
}

TEST_F(Keeper, TellsWhyItCannot) {
  MemoryKeeper keeper(path_ + "/no/such/folder");
  await(keeper, keeper.keep(memory(1)));
  EXPECT_EQ(keeper.failure(), path_ + "/no/such/folder cannot be written: No such file or directory");
}

TEST_F(Keeper, WithoutAPathNothingIsWaitedFor) {
  MemoryKeeper keeper("");
  EXPECT_TRUE(keeper.kept(keeper.keep(memory(1))));
}

}  // namespace
}  // namespace hecaton::services
