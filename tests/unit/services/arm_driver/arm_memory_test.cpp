#include "services/arm_driver/arm_memory.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

class ArmMemoryTest : public ::testing::Test {
 protected:
  ~ArmMemoryTest() override { std::filesystem::remove(path_); }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("hecaton_arm_" + std::to_string(getpid()))).string();
  const ArmLease mandate_{"planner/arm1@beta", 7};
  const planner::JointVector first_ = (planner::JointVector(3) << 0.1, -0.2, 0.3).finished();
  const planner::JointVector second_ = (planner::JointVector(3) << 1.0, 2.0, 3.0).finished();
};

TEST_F(ArmMemoryTest, NewKnowsNothing) {
  EXPECT_FALSE(ArmMemory(path_, 3).recall());
}

TEST_F(ArmMemoryTest, WithoutAFileNothingIsRemembered) {
  ArmMemory memory("", 3);
  memory.remember(first_, mandate_);
  EXPECT_FALSE(memory.recall());
}

TEST_F(ArmMemoryTest, TheLastCounts) {
  ArmMemory memory(path_, 3);
  for (int i = 0; i < 5; ++i) {
    memory.remember(first_, mandate_);
    EXPECT_EQ(memory.recall().value().q, first_);
    memory.remember(second_, mandate_);
    EXPECT_EQ(memory.recall().value().q, second_);
  }
}

TEST_F(ArmMemoryTest, SurvivesKill) {
  const pid_t child = fork();
  if (child == 0) {
    ArmMemory memory(path_, 3);
    memory.remember(first_, mandate_);
    memory.remember(second_, mandate_);
    std::raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  ArmMemory successor(path_, 3);
  ASSERT_TRUE(successor.recall());
  EXPECT_EQ(successor.recall()->q, second_);
  EXPECT_EQ(successor.recall()->mandate, mandate_);
  successor.remember(first_, mandate_);
  EXPECT_EQ(successor.recall().value().q, first_) << "goes on counting";
}

// Half a name would be a planner that nobody is: nobody could ever command the arm.
TEST_F(ArmMemoryTest, OfANameThatIsTooLongTheTermIsKept) {
  ArmMemory memory(path_, 3);
  memory.remember(first_, {std::string(256, 'p'), 9});
  EXPECT_EQ(memory.recall().value().mandate, (ArmLease{"", 9}));
  memory.remember(first_, {std::string(255, 'p'), 9});
  EXPECT_EQ(memory.recall().value().mandate, (ArmLease{std::string(255, 'p'), 9}));
}

TEST_F(ArmMemoryTest, OfAnotherArmIsNotTaken) {
  ArmMemory(path_, 3).remember(first_, mandate_);
  EXPECT_FALSE(ArmMemory(path_, 4).recall());
}

TEST_F(ArmMemoryTest, FolderIsToldInASentence) {
  const std::string folder = std::filesystem::temp_directory_path().string();
  try {
    ArmMemory memory(folder, 3);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), folder + ": what the driver must not forget cannot be kept there: Is a directory");
  }
}

}  // namespace
}  // namespace hecaton::services
