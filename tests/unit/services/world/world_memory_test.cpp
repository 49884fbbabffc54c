#include <filesystem>
#include <numbers>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/bus/message_file.hpp"
#include "services/runtime/kept_file.hpp"
#include "services/world/world_checkpoint.hpp"
#include "services/world/world_edit.hpp"
#include "tests/support/full_disk.hpp"

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
  ASSERT_TRUE(first.add(ball("crate", at_point(2, 3, 4))).done());
  ASSERT_TRUE(first.move("rock", at_point(5, 1, 0)).done());
  ASSERT_TRUE(first.remove("gone").done());
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
  ASSERT_TRUE(first.attach("box", "arm").done());
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
  ASSERT_TRUE(first.attach("box", "arm").done());
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
  ~Keeper() override {
    std::filesystem::remove(path_);
    std::filesystem::remove(other_file_of(path_));
  }
  static msg::WorldMemory memory(double time, std::size_t size = 0) {
    msg::WorldMemory message;
    message.time(time);
    message.cell(std::string(size, 'x'));
    return message;
  }
  /// Why it was not kept; empty: it was.
  static std::optional<std::string> await(const CheckpointWriter& keeper, std::uint64_t number) {
    while (!keeper.outcome(number).known) std::this_thread::yield();
    return keeper.outcome(number).failure;
  }
  static bool is_kept(const CheckpointWriter::Outcome& outcome) { return outcome.known && !outcome.failure; }
  [[nodiscard]] double kept() const {
    const bus::ReadMessage read = bus::read_message(path_);
    EXPECT_TRUE(read.message) << read.error;
    return read.message ? read.message->time() : -1.0;
  }
  std::string path_ =
      (std::filesystem::temp_directory_path() / ("memory_keeper_test-" + std::to_string(getpid()))).string();
};

TEST_F(Keeper, WritesTheNewest) {
  CheckpointWriter keeper(path_);
  std::uint64_t last = 0;
  for (int i = 1; i <= 100; ++i) last = keeper.keep(memory(i));
  EXPECT_EQ(await(keeper, last), std::nullopt);
  EXPECT_TRUE(is_kept(keeper.outcome(1))) << "a newer one is kept";
  EXPECT_EQ(kept(), 100.0);
  EXPECT_EQ(keeper.failure(), std::nullopt);
}

TEST_F(Keeper, WritesWhatIsLeftWhenItEnds) {
  { static_cast<void>(CheckpointWriter(path_).keep(memory(7))); }
  EXPECT_EQ(kept(), 7.0);
}

TEST_F(Keeper, WithoutAPathNothingIsWaitedFor) {
  CheckpointWriter keeper("");
  EXPECT_TRUE(is_kept(keeper.outcome(keeper.keep(memory(1)))));
}

constexpr std::size_t kRoom = 1U << 16U;  // that the first memory takes

TEST_F(Keeper, OnAFullDiskTheLastGoodMemoryStaysAndTheRestIsSaidNotToBeKept) {
  const std::string refusal = path_ + " cannot be written: File too large";
  CheckpointWriter keeper(path_);
  ASSERT_EQ(await(keeper, keeper.keep(memory(1))), std::nullopt);
  {
    const test::FullDisk full(kRoom);
    const std::uint64_t large = keeper.keep(memory(2, kRoom));
    EXPECT_EQ(await(keeper, large), refusal);
    EXPECT_EQ(keeper.failure(), refusal);
    EXPECT_EQ(kept(), 1.0);
    EXPECT_EQ(await(keeper, keeper.keep(memory(3))), std::nullopt) << "what has room is remembered";
    EXPECT_EQ(keeper.failure(), std::nullopt);
    EXPECT_EQ(kept(), 3.0);
    EXPECT_EQ(await(keeper, keeper.keep(memory(4, kRoom))), refusal);
  }
  EXPECT_EQ(await(keeper, keeper.keep(memory(5, kRoom))), std::nullopt) << "there is room again";
  EXPECT_EQ(keeper.failure(), std::nullopt);
  EXPECT_EQ(kept(), 5.0);
}

msg::WorldEditReply reply_to(std::uint64_t request) {
  msg::WorldEditReply reply;
  reply.request_id(request);
  reply.done(true);
  return reply;
}

TEST_F(Keeper, RepliesSayOfWhichEditsThereIsNoMemory) {
  CheckpointWriter keeper(path_);
  EditReplies replies;
  std::vector<msg::WorldEditReply> told;
  const auto take = [&](std::uint64_t memory) {
    static_cast<void>(await(keeper, memory));
    told = replies.take(keeper);
  };
  const std::uint64_t first = keeper.keep(memory(1));
  replies.owe(first, reply_to(1));
  take(first);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].cause().text(), "");

  const test::FullDisk full(kRoom);
  const std::uint64_t second = keeper.keep(memory(2, kRoom));
  replies.owe(second, reply_to(2));
  msg::WorldEditReply refused = reply_to(3);
  refused.done(false);
  refused.cause(make_cause(msg::CauseKind::CAUSE_UNKNOWN_NAME, {}, "no such obstacle"));
  replies.owe(0, refused);
  take(second);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].request_id(), 2U);
  EXPECT_TRUE(told[0].done());
  EXPECT_EQ(told[0].cause().text(), "the edit is not remembered, and lost with the world's process: " + path_ +
                                        " cannot be written: File too large");
  EXPECT_EQ(told[1].request_id(), 3U);
  EXPECT_EQ(told[1].cause().text(), "no such obstacle");
  EXPECT_TRUE(replies.take(keeper).empty());
}

// A disk that does not answer: who opens a pipe to write waits until somebody reads it.
TEST_F(Keeper, AThreadThatHangsKeepsNobodyWaiting) {
  ASSERT_EQ(mkfifo(other_file_of(path_).c_str(), 0600), 0);
  CheckpointWriter keeper(path_);
  EditReplies replies;
  replies.owe(keeper.keep(memory(1)), reply_to(1));
  auto now = CheckpointWriter::Clock::now();
  const auto look_for = [&](CheckpointWriter::Clock::duration time) {
    for (const auto until = now + time; now < until;) keeper.look(now += std::chrono::milliseconds(10));
  };
  look_for(CheckpointWriter::kLongestWrite);
  EXPECT_EQ(keeper.failure(), std::nullopt);
  EXPECT_TRUE(replies.take(keeper).empty());
  look_for(CheckpointWriter::kLongestWrite);
  const std::string silent = "the thread that writes " + path_ + " has not answered for 1 s";
  EXPECT_EQ(keeper.failure(), silent);
  const auto told = replies.take(keeper);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].cause().text(), "the edit is not remembered, and lost with the world's process: " + silent);

  const int reader = open(other_file_of(path_).c_str(), O_RDONLY | O_CLOEXEC);  // now it goes on, and fails
  while (keeper.outcome(1).failure == silent) std::this_thread::yield();
  EXPECT_EQ(keeper.outcome(1).failure, path_ + " cannot be written: Illegal seek");
  look_for(CheckpointWriter::kLongestWrite);
  EXPECT_EQ(keeper.failure(), path_ + " cannot be written: Illegal seek");
  close(reader);
}

}  // namespace
}  // namespace hecaton::services
