// What a planner's successor finds of its goals.
#include "services/planner/goal_memory.hpp"

#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

class GoalMemoryTest : public ::testing::Test {
 protected:
  ~GoalMemoryTest() override { std::filesystem::remove(path_); }

  static void expect_same(const std::optional<GoalMemory::Remembered>& got, const GoalMemory::Remembered& wanted) {
    ASSERT_TRUE(got);
    EXPECT_TRUE(got->account == wanted.account);
    EXPECT_EQ(got->mandate, wanted.mandate);
    EXPECT_EQ(got->stamp_ns, wanted.stamp_ns);
    EXPECT_EQ(got->until_ns, wanted.until_ns);
  }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("hecaton_goals_" + std::to_string(getpid()))).string();
  const planner::JointVector q_ = (planner::JointVector(3) << 0.1, -0.2, 0.3).finished();
  const GoalMemory::Remembered busy_{{GoalAccount::Active{"g2", "cli/a-1", 17, 30.0, 1.5, q_},
                                      {{"g0", msg::GoalState::GOAL_CANCELLED}, {"g1", msg::GoalState::GOAL_REPLACED}},
                                      {5, 6, 7}},
                                     {"planner/arm1@beta", 7},
                                     123456789,
                                     123456800};
  const GoalMemory::Remembered idle_{
      {std::nullopt, {{"g2", msg::GoalState::GOAL_REACHED}}, {5, 6, 7, 8}}, {"", 8}, 200000000, 200000000};
};

TEST_F(GoalMemoryTest, NewKnowsNothing) {
  EXPECT_FALSE(GoalMemory(path_, 3).recall());
}

TEST_F(GoalMemoryTest, WithoutAFileNothingIsRemembered) {
  GoalMemory memory("", 3);
  memory.remember(busy_);
  EXPECT_FALSE(memory.recall());
}

TEST_F(GoalMemoryTest, TheLastCounts) {
  GoalMemory memory(path_, 3);
  for (int i = 0; i < 3; ++i) {
    memory.remember(busy_);
    expect_same(memory.recall(), busy_);
    memory.remember(idle_);
    expect_same(memory.recall(), idle_);
  }
}

TEST_F(GoalMemoryTest, SurvivesKill) {
  const pid_t child = fork();
  if (child == 0) {
    GoalMemory memory(path_, 3);
    memory.remember(idle_);
    memory.remember(busy_);
    std::raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  GoalMemory successor(path_, 3);
  expect_same(successor.recall(), busy_);
  successor.remember(idle_);
  expect_same(successor.recall(), idle_);
}

TEST_F(GoalMemoryTest, KnowsUntilWhenItWasAllThereWasToKnow) {
  GoalMemory memory(path_, 3);
  memory.confirm(1);
  EXPECT_FALSE(memory.recall()) << "there is nothing to confirm";
  memory.remember(busy_);
  memory.confirm(123457000);
  GoalMemory::Remembered confirmed = busy_;
  confirmed.until_ns = 123457000;
  expect_same(memory.recall(), confirmed);
  memory.remember(idle_);
  expect_same(memory.recall(), idle_);
  GoalMemory successor(path_, 3);
  successor.confirm(200000005);
  EXPECT_EQ(successor.recall()->until_ns, 200000005);
}

TEST_F(GoalMemoryTest, NamesAndListsOfTheGreatestLengthAreKept) {
  GoalMemory::Remembered longest = busy_;
  longest.account.active->goal = std::string(GoalAccount::kLongestName, 'g');
  longest.account.active->client = std::string(GoalAccount::kLongestName, 'c');
  longest.account.ends[0].goal = std::string(GoalAccount::kLongestName, 'e');
  longest.account.handled.assign(GoalAccount::kHandled, 7);
  GoalMemory memory(path_, 3);
  memory.remember(longest);
  expect_same(memory.recall(), longest);
}

TEST_F(GoalMemoryTest, OfAnotherArmIsNotTaken) {
  GoalMemory(path_, 3).remember(busy_);
  EXPECT_FALSE(GoalMemory(path_, 4).recall());
}

}  // namespace
}  // namespace hecaton::services
