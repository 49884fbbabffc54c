#include "services/world/world_checkpoint.hpp"

#include <filesystem>
#include <numbers>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/bus/message_file.hpp"
#include "services/runtime/atomic_file.hpp"
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

/// A world restored from `checkpoint`.
world::BulletWorld successor(const msg::WorldCheckpoint& checkpoint) {
  const auto next = restored(checkpoint, world::Scene{});
  EXPECT_TRUE(next) << next.error;
  world::BulletWorld world(next->scene, ball_arm());
  world.restore(next->time, next->edition, next->contacts);
  return world;
}

TEST(WorldCheckpoint, RestoresEditsMotionsAndTime) {
  world::Scene scene;
  // Half a turn takes π s at 1 rad/s: from x = 1 to x = −1 about the origin.
  scene.obstacles = {ball("moon", at_point(1, 0, 0), world::CircleMotion{Vector3d::Zero(), Vector3d::UnitZ(), 1.0}),
                     ball("rock", at_point(5, 0, 0)), ball("gone", at_point(6, 0, 0))};
  world::BulletWorld first(scene, ball_arm());
  ASSERT_TRUE(first.add(ball("crate", at_point(2, 3, 4))).done());
  ASSERT_TRUE(first.move("rock", at_point(5, 1, 0)).done());
  ASSERT_TRUE(first.remove("gone").done());
  first.step(1.0);

  world::BulletWorld second = successor(checkpoint_of(first));
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

TEST(WorldCheckpoint, RestoresAFallingObstacle) {
  world::Scene scene;
  world::DynamicMotion motion;
  scene.obstacles = {ball("stone", at_point(0, 0, 10), motion)};
  world::BulletWorld first(scene, ball_arm());
  first.step(0.5);
  world::BulletWorld second = successor(checkpoint_of(first));
  EXPECT_LT((second.snapshot().states[0].X_WO.translation() - first.snapshot().states[0].X_WO.translation()).norm(),
            1e-12);
  first.step(0.25);
  second.step(0.25);
  EXPECT_LT((second.snapshot().states[0].X_WO.translation() - first.snapshot().states[0].X_WO.translation()).norm(),
            1e-6);
}

TEST(WorldCheckpoint, RestoresACarriedObstacle) {
  world::Scene scene;
  scene.obstacles = {ball("box", at_point(0, 0, 0.5))};
  world::BulletWorld first(scene, ball_arm());
  put(first, at_point(0, 0, 0));
  first.step(0.01);
  ASSERT_TRUE(first.attach("box", "arm").done());
  put(first, at_point(1, 0, 0));
  first.step(0.01);

  world::BulletWorld second = successor(checkpoint_of(first));
  EXPECT_EQ(second.snapshot().states[0].X_WO.translation(), Vector3d(1, 0, 0.5))
      << "also before a state of the arm arrives";
  put(second, at_point(2, 0, 0));
  second.step(0.01);
  EXPECT_EQ(second.snapshot().states[0].X_WO.translation(), Vector3d(2, 0, 0.5));
}

TEST(WorldCheckpoint, CountsALastingContactOnce) {
  world::Scene scene;
  scene.obstacles = {ball("post", at_point(0, 0, 0))};
  world::BulletWorld first(scene, ball_arm());
  put(first, at_point(0.15, 0, 0));  // 5 cm deep
  first.step(0.01);
  ASSERT_EQ(first.contact_monitor().report().contacts, 1U);

  world::BulletWorld second = successor(checkpoint_of(first));
  EXPECT_EQ(second.contact_monitor().report().contacts, 1U);
  EXPECT_NEAR(second.contact_monitor().report().smallest.distance, -0.05, 1e-4);
  ASSERT_EQ(second.contact_monitor().report().events.size(), 1U);
  EXPECT_EQ(second.contact_monitor().report().events[0].b, "post");
  put(second, at_point(0.15, 0, 0));
  second.step(0.01);
  EXPECT_EQ(second.contact_monitor().report().contacts, 1U);
  for (const double x : {0.5, 0.15}) {
    put(second, at_point(x, 0, 0));
    second.step(0.01);
  }
  EXPECT_EQ(second.contact_monitor().report().contacts, 2U) << "parted and touched again";
}

TEST(WorldCheckpoint, KeepsToleratedContactsOfAGraspedObstacle) {
  world::Scene scene;
  scene.obstacles = {ball("box", at_point(0, 0, 1)), ball("table", at_point(0, 0, 0.85))};  // 5 cm deep in it
  world::BulletWorld first(scene, ball_arm());
  put(first, at_point(0, 0, 1.5));
  first.step(0.01);
  ASSERT_TRUE(first.attach("box", "arm").done());
  for (const bool stepped_before : {false, true}) {
    if (stepped_before) first.step(0.01);
    world::BulletWorld second = successor(checkpoint_of(first));
    put(second, at_point(0, 0, 1.5));
    second.step(0.01);
    EXPECT_EQ(second.contact_monitor().report().contacts, 0U) << stepped_before;
  }
}

TEST(WorldCheckpoint, IsRefusedWithASentenceWhenUnusable) {
  msg::WorldCheckpoint checkpoint =
      checkpoint_of(world::BulletWorld(world::Scene{{ball("a", at_point(0, 0, 0))}}, ball_arm()));
  checkpoint.obstacles()[0].shapes()[0].dimensions().x(-1.0);
  EXPECT_NE(restored(checkpoint, world::Scene{}).error.find("a"), std::string::npos);
  checkpoint.obstacles().clear();
  checkpoint.contact_report().kinds().clear();
  EXPECT_EQ(restored(checkpoint, world::Scene{}).error, "contact_report: kinds must have 3 entries");
}

class CheckpointWriterTest : public ::testing::Test {
 protected:
  ~CheckpointWriterTest() override {
    std::filesystem::remove(path_);
    std::filesystem::remove(spare_file_of(path_));
  }
  static msg::WorldCheckpoint checkpoint(double time, std::size_t size = 0) {
    msg::WorldCheckpoint message;
    message.time(time);
    message.cell(std::string(size, 'x'));
    return message;
  }
  /// Waits for the outcome of this checkpoint and returns its failure.
  static std::optional<std::string> await(const CheckpointWriter& writer, std::uint64_t number) {
    while (!writer.outcome(number).known) std::this_thread::yield();
    return writer.outcome(number).failure;
  }
  static bool is_written(const CheckpointWriter::Outcome& outcome) { return outcome.known && !outcome.failure; }
  [[nodiscard]] double time_in_file() const {
    const bus::ReadMessage read = bus::read_message(path_);
    EXPECT_TRUE(read.message) << read.error.value_or("");
    return read.message ? read.message->time() : -1.0;
  }
  std::string path_ =
      (std::filesystem::temp_directory_path() / ("checkpoint_writer_test-" + std::to_string(getpid()))).string();
};

TEST_F(CheckpointWriterTest, WritesTheNewestCheckpoint) {
  CheckpointWriter writer(path_);
  std::uint64_t last = 0;
  for (int i = 1; i <= 100; ++i) last = writer.write(checkpoint(i));
  EXPECT_EQ(await(writer, last), std::nullopt);
  EXPECT_TRUE(is_written(writer.outcome(1))) << "a newer one is in the file";
  EXPECT_EQ(time_in_file(), 100.0);
  EXPECT_EQ(writer.failure(), std::nullopt);
}

TEST_F(CheckpointWriterTest, WritesTheLastCheckpointWhenItEnds) {
  { static_cast<void>(CheckpointWriter(path_).write(checkpoint(7))); }
  EXPECT_EQ(time_in_file(), 7.0);
}

TEST_F(CheckpointWriterTest, ReportsSuccessAtOnceWithoutAPath) {
  CheckpointWriter writer("");
  EXPECT_TRUE(is_written(writer.outcome(writer.write(checkpoint(1)))));
}

constexpr std::size_t kRoom = 1U << 16U;  // of the first checkpoint [byte]

TEST_F(CheckpointWriterTest, KeepsTheLastGoodCheckpointWhileTheDiskIsFull) {
  const std::string refusal = path_ + " cannot be written: File too large";
  CheckpointWriter writer(path_);
  ASSERT_EQ(await(writer, writer.write(checkpoint(1))), std::nullopt);
  {
    const test::FullDisk full(kRoom);
    const std::uint64_t large = writer.write(checkpoint(2, kRoom));
    EXPECT_EQ(await(writer, large), refusal);
    EXPECT_EQ(writer.failure(), refusal);
    EXPECT_EQ(time_in_file(), 1.0);
    EXPECT_EQ(await(writer, writer.write(checkpoint(3))), std::nullopt) << "the reserved room suffices";
    EXPECT_EQ(writer.failure(), std::nullopt);
    EXPECT_EQ(time_in_file(), 3.0);
    EXPECT_EQ(await(writer, writer.write(checkpoint(4, kRoom))), refusal);
  }
  EXPECT_EQ(await(writer, writer.write(checkpoint(5, kRoom))), std::nullopt) << "there is room again";
  EXPECT_EQ(writer.failure(), std::nullopt);
  EXPECT_EQ(time_in_file(), 5.0);
}

msg::WorldEditReply reply_to(std::uint64_t request) {
  msg::WorldEditReply reply;
  reply.request_id(request);
  reply.done(true);
  return reply;
}

TEST_F(CheckpointWriterTest, RepliesReportEditsThatAreNotPersisted) {
  CheckpointWriter writer(path_);
  EditReplies replies;
  std::vector<msg::WorldEditReply> ready;
  const auto take = [&](std::uint64_t checkpoint) {
    static_cast<void>(await(writer, checkpoint));
    ready = replies.take(writer);
  };
  const std::uint64_t first = writer.write(checkpoint(1));
  replies.add(first, reply_to(1));
  take(first);
  ASSERT_EQ(ready.size(), 1U);
  EXPECT_EQ(ready[0].cause().text(), "");

  const test::FullDisk full(kRoom);
  const std::uint64_t second = writer.write(checkpoint(2, kRoom));
  replies.add(second, reply_to(2));
  msg::WorldEditReply refused = reply_to(3);
  refused.done(false);
  refused.cause(make_cause(msg::CauseKind::CAUSE_UNKNOWN_NAME, {}, "no such obstacle"));
  replies.add(0, refused);
  take(second);
  ASSERT_EQ(ready.size(), 2U);
  EXPECT_EQ(ready[0].request_id(), 2U);
  EXPECT_TRUE(ready[0].done());
  EXPECT_EQ(ready[0].cause().text(), "the edit is not persisted and will be lost when the world restarts: " + path_ +
                                         " cannot be written: File too large");
  EXPECT_EQ(ready[1].request_id(), 3U);
  EXPECT_EQ(ready[1].cause().text(), "no such obstacle");
  EXPECT_TRUE(replies.take(writer).empty());
}

// A pipe acts as a disk that does not answer: to open it for writing blocks until a reader opens it.
TEST_F(CheckpointWriterTest, ReportsAHangingThread) {
  ASSERT_EQ(mkfifo(spare_file_of(path_).c_str(), 0600), 0);
  CheckpointWriter writer(path_);
  EditReplies replies;
  replies.add(writer.write(checkpoint(1)), reply_to(1));
  auto now = CheckpointWriter::Clock::now();
  const auto run_for = [&](CheckpointWriter::Clock::duration time) {
    for (const auto until = now + time; now < until;) writer.update(now += std::chrono::milliseconds(10));
  };
  run_for(CheckpointWriter::kLongestWrite);
  EXPECT_EQ(writer.failure(), std::nullopt);
  EXPECT_TRUE(replies.take(writer).empty());
  run_for(CheckpointWriter::kLongestWrite);
  const std::string silent = "the thread that writes " + path_ + " has not answered for 1 s";
  EXPECT_EQ(writer.failure(), silent);
  const auto ready = replies.take(writer);
  ASSERT_EQ(ready.size(), 1U);
  EXPECT_EQ(ready[0].cause().text(), "the edit is not persisted and will be lost when the world restarts: " + silent);

  const int reader = open(spare_file_of(path_).c_str(), O_RDONLY | O_CLOEXEC);  // now the write continues, and fails
  while (writer.outcome(1).failure == silent) std::this_thread::yield();
  EXPECT_EQ(writer.outcome(1).failure, path_ + " cannot be written: Illegal seek");
  run_for(CheckpointWriter::kLongestWrite);
  EXPECT_EQ(writer.failure(), path_ + " cannot be written: Illegal seek");
  close(reader);
}

}  // namespace
}  // namespace hecaton::services
