#include "services/supervisor/replication/checkpoint.hpp"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/runtime/atomic_file.hpp"
#include "tests/support/full_disk.hpp"

namespace hecaton::services {
namespace {

Checkpoint some_checkpoint() {
  Checkpoint memory;
  memory.term = 7;
  memory.orders.cell = msg::Mode::MODE_HOLD;
  memory.orders.arms = {{"left", msg::Mode::MODE_STOP}, {"right", msg::Mode::MODE_HOLD}};
  memory.causes = {
      {"", make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "arm1/wrist", "arm1/wrist touched pallet")},
      {"right", make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/right", "planner/right: signal 9 (Killed)")}};
  memory.faults.open["planner/left"] = {7,
                                        2,
                                        msg::CauseKind::CAUSE_PROCESS_DIED,
                                        msg::Severity::SEVERITY_ERROR,
                                        "planner/left",
                                        "planner/left: signal 9 (Killed)",
                                        std::chrono::nanoseconds(50),
                                        std::chrono::nanoseconds(4),
                                        {}};
  memory.faults.cleared.push_back({6, 9, msg::CauseKind::CAUSE_NODE_SILENT, msg::Severity::SEVERITY_WARNING, "world",
                                   "world: no beat", std::chrono::nanoseconds(10), std::nullopt,
                                   std::chrono::nanoseconds(30)});
  memory.unreplicated.cell = msg::Mode::MODE_HOLD;
  memory.unreplicated.arms = {{"left", msg::Mode::MODE_STOP}};
  memory.orders.speed = 0.5;
  memory.orders.speeds = {{"left", 0.3}};
  memory.unreplicated.speed = 0.5;
  return memory;
}

class CheckpointFileTest : public ::testing::Test {
 protected:
  ~CheckpointFileTest() override {
    std::filesystem::remove(path_);
    std::filesystem::remove(spare_file_of(path_));
  }
  std::string path_ = (std::filesystem::temp_directory_path() / ("memory_test-" + std::to_string(getpid()))).string();
};

TEST(CheckpointText, ContainsTermOrdersAndFaults) {
  const std::string text =
      "term 7\ncell hold\narm left stop\narm right hold\n"
      "because / held_by_fault arm1/wrist arm1/wrist touched pallet\n"
      "because right held_by_fault planner/right planner/right: signal 9 (Killed)\n"
      "unreplicated / hold\nunreplicated left stop\n"
      "speed / 0.5\nspeed left 0.29999999999999999\nunreplicated_speed / 0.5\n"
      "fault 7 2 process_died 2 50 4 open planner/left planner/left planner/left: signal 9 (Killed)\n"
      "fault 6 9 node_silent 1 10 -1 30 - world world: no beat\n";
  EXPECT_EQ(checkpoint_text(some_checkpoint()), text);
  EXPECT_EQ(parse_checkpoint(text), some_checkpoint());
}

// Texts of another supervisor's faults may contain anything.
TEST(CheckpointText, ReadsBackAnyText) {
  Checkpoint memory = some_checkpoint();
  for (const auto* text : {"", " ", "two\nlines", "tab\tin it", "\n"}) {
    memory.faults.cleared.front().subject = text;
    memory.faults.cleared.front().description = text;
    memory.causes[""] = make_cause(msg::CauseKind::CAUSE_CONTACT, text, text);
    const auto read = parse_checkpoint(checkpoint_text(memory));
    ASSERT_TRUE(read) << "'" << text << "'";
    EXPECT_EQ(read->orders, memory.orders);
    EXPECT_EQ(read->faults.cleared.front().since, memory.faults.cleared.front().since);
  }
}

TEST(CheckpointText, RejectsMalformedText) {
  for (const auto* text :
       {"", "term\n", "term x\n", "cell run\n", "term 1\ncell sleep\n", "term 1\narm left\n",
        "term 1\nsomething else\n", "term 1\nunreplicated left\n", "term 1\nbecause left no_such_kind a b\n",
        "term 1\nfault 1 1 no_goal 1 10 4 30 - world x\n", "term 1\nfault 1 1 no_such_kind 1 10 4 30 - world x\n",
        "term 1\nfault 1 1 node_silent 9 10 4 30 - world x\n", "term 1\nfault 1 1 node_silent 1\n",
        "term 1\nfault 1 1 node_silent 1 10 4 never - world x\n", "term 18446744073709551615\n"}) {
    EXPECT_FALSE(parse_checkpoint(text)) << text;
  }
}

TEST_F(CheckpointFileTest, IsReadBackAndReplaced) {
  EXPECT_FALSE(read_checkpoint(path_));
  ASSERT_EQ(write_checkpoint(path_, some_checkpoint()), std::nullopt);
  EXPECT_EQ(read_checkpoint(path_), some_checkpoint());
  Checkpoint next = some_checkpoint();
  next.term = 8;
  next.orders = {};
  ASSERT_EQ(write_checkpoint(path_, next), std::nullopt);
  EXPECT_EQ(read_checkpoint(path_), next);
}

TEST_F(CheckpointFileTest, RejectsADamagedFile) {
  std::ofstream(path_) << "term 7\ncell st";
  EXPECT_THROW(static_cast<void>(read_checkpoint(path_)), std::runtime_error);
}

TEST_F(CheckpointFileTest, SetsADamagedFileAside) {
  for (const auto* damaged : {"term 7\ncell st", "", "term 18446744073709551615\ncell run\n",
                              "term 4611686018427387904\ncell run\n", "\x1B[2J"}) {
    std::ofstream(path_, std::ios::trunc) << damaged;
    CheckpointFile file(path_);
    ASSERT_TRUE(file.lost()) << damaged;
    EXPECT_EQ(file.stored(), Checkpoint());
    EXPECT_TRUE(std::filesystem::exists(path_ + ".unusable"));
    file.store(some_checkpoint());
    EXPECT_FALSE(CheckpointFile(path_).lost()) << "the new checkpoint is in use";
    std::filesystem::remove(path_ + ".unusable");
  }
}

TEST_F(CheckpointFileTest, ReportsAnUnwritablePath) {
  EXPECT_TRUE(write_checkpoint(path_ + "/no/such/folder", some_checkpoint()));
}

TEST_F(CheckpointFileTest, ReservesRoomBeforehand) {
  ASSERT_EQ(write_checkpoint(path_, some_checkpoint()), std::nullopt);
  for (const std::string& file : {path_, spare_file_of(path_)}) {
    struct stat room {};
    ASSERT_EQ(stat(file.c_str(), &room), 0);
    EXPECT_GE(room.st_size, 1 << 16) << file;
  }
  struct stat before {};
  ASSERT_EQ(stat(path_.c_str(), &before), 0);
  for (std::uint64_t term = 8; term < 12; ++term) {
    Checkpoint next = some_checkpoint();
    next.term = term;
    next.orders.arms["left"] = msg::Mode::MODE_HOLD;
    ASSERT_EQ(write_checkpoint(path_, next), std::nullopt);
    EXPECT_EQ(read_checkpoint(path_), next);
  }
  struct stat after {};
  ASSERT_EQ(stat(path_.c_str(), &after), 0);
  EXPECT_EQ(after.st_ino, before.st_ino) << "the same two files take turns";
  EXPECT_EQ(after.st_size, before.st_size);
}

TEST_F(CheckpointFileTest, KeepsTheFormerCheckpointOnAFullDisk) {
  {
    const test::FullDisk full(1000);
    EXPECT_TRUE(write_checkpoint(path_, some_checkpoint())) << "no room is reserved yet";
  }
  ASSERT_EQ(write_checkpoint(path_, some_checkpoint()), std::nullopt);
  Checkpoint large = some_checkpoint();
  large.causes["left"] = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "x", std::string(1 << 17, 'x'));
  {
    const test::FullDisk full(1 << 16);
    EXPECT_TRUE(write_checkpoint(path_, large));
    EXPECT_EQ(read_checkpoint(path_), some_checkpoint());
    Checkpoint next = some_checkpoint();
    next.term = 8;
    EXPECT_EQ(write_checkpoint(path_, next), std::nullopt) << "the reserved room suffices";
    EXPECT_EQ(read_checkpoint(path_), next);
  }
  EXPECT_EQ(write_checkpoint(path_, large), std::nullopt);
  EXPECT_EQ(read_checkpoint(path_), large);
}

}  // namespace
}  // namespace hecaton::services
