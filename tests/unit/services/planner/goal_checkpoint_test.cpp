// What a planner's successor finds of its goals.
#include "services/planner/goal_checkpoint.hpp"

#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

class GoalCheckpointTest : public ::testing::Test {
 protected:
  ~GoalCheckpointTest() override { std::filesystem::remove(path_); }

  static void expect_same(const std::optional<GoalCheckpoint::Saved>& got, const GoalCheckpoint::Saved& wanted) {
    ASSERT_TRUE(got);
    EXPECT_TRUE(got->snapshot == wanted.snapshot);
    EXPECT_EQ(got->mandate, wanted.mandate);
    EXPECT_EQ(got->stamp_ns, wanted.stamp_ns);
    EXPECT_EQ(got->until_ns, wanted.until_ns);
  }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("hecaton_goals_" + std::to_string(getpid()))).string();
  const planner::JointVector q_ = (planner::JointVector(3) << 0.1, -0.2, 0.3).finished();
  const GoalCheckpoint::Saved busy_{{GoalSnapshot::Active{"g2", "cli/a-1", 17, 30.0, 1.5, q_},
                                     {{"g0", msg::GoalState::GOAL_CANCELLED}, {"g1", msg::GoalState::GOAL_REPLACED}},
                                     {5, 6, 7}},
                                    {"planner/arm1@beta", 7},
                                    123456789,
                                    123456800};
  const GoalCheckpoint::Saved idle_{
      {std::nullopt, {{"g2", msg::GoalState::GOAL_REACHED}}, {5, 6, 7, 8}}, {"", 8}, 200000000, 200000000};
};

TEST_F(GoalCheckpointTest, NewKnowsNothing) {
  EXPECT_FALSE(GoalCheckpoint(path_, 3).load());
}

TEST_F(GoalCheckpointTest, WithoutAFileNothingIsSaved) {
  GoalCheckpoint memory("", 3);
  memory.save(busy_);
  EXPECT_FALSE(memory.load());
}

TEST_F(GoalCheckpointTest, TheLastCounts) {
  GoalCheckpoint memory(path_, 3);
  for (int i = 0; i < 3; ++i) {
    memory.save(busy_);
    expect_same(memory.load(), busy_);
    memory.save(idle_);
    expect_same(memory.load(), idle_);
  }
}

TEST_F(GoalCheckpointTest, SurvivesKill) {
  const pid_t child = fork();
  if (child == 0) {
    GoalCheckpoint memory(path_, 3);
    memory.save(idle_);
    memory.save(busy_);
    std::raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  GoalCheckpoint successor(path_, 3);
  expect_same(successor.load(), busy_);
  successor.save(idle_);
  expect_same(successor.load(), idle_);
}

TEST_F(GoalCheckpointTest, KnowsUntilWhenItWasAllThereWasToKnow) {
  GoalCheckpoint memory(path_, 3);
  memory.confirm(1);
  EXPECT_FALSE(memory.load()) << "there is nothing to confirm";
  memory.save(busy_);
  memory.confirm(123457000);
  GoalCheckpoint::Saved confirmed = busy_;
  confirmed.until_ns = 123457000;
  expect_same(memory.load(), confirmed);
  memory.save(idle_);
  expect_same(memory.load(), idle_);
  GoalCheckpoint successor(path_, 3);
  successor.confirm(200000005);
  EXPECT_EQ(successor.load()->until_ns, 200000005);
}

TEST_F(GoalCheckpointTest, NamesAndListsOfTheGreatestLengthAreKept) {
  GoalCheckpoint::Saved longest = busy_;
  longest.snapshot.active->goal = std::string(GoalSnapshot::kLongestName, 'g');
  longest.snapshot.active->client = std::string(GoalSnapshot::kLongestName, 'c');
  longest.snapshot.ends[0].goal = std::string(GoalSnapshot::kLongestName, 'e');
  longest.snapshot.handled.assign(GoalSnapshot::kHandled, 7);
  GoalCheckpoint memory(path_, 3);
  memory.save(longest);
  expect_same(memory.load(), longest);
}

TEST_F(GoalCheckpointTest, OfAnotherArmIsNotTaken) {
  GoalCheckpoint(path_, 3).save(busy_);
  EXPECT_FALSE(GoalCheckpoint(path_, 4).load());
}

}  // namespace
}  // namespace hecaton::services
