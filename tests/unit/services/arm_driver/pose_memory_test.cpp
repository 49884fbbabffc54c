#include "services/arm_driver/pose_memory.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

class PoseMemoryTest : public ::testing::Test {
 protected:
  ~PoseMemoryTest() override { std::filesystem::remove(path_); }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("hecaton_pose_" + std::to_string(getpid()))).string();
  const planner::JointVector first_ = (planner::JointVector(3) << 0.1, -0.2, 0.3).finished();
  const planner::JointVector second_ = (planner::JointVector(3) << 1.0, 2.0, 3.0).finished();
};

TEST_F(PoseMemoryTest, NewKnowsNothing) {
  EXPECT_EQ(PoseMemory(path_, 3).recall().size(), 0);
}

TEST_F(PoseMemoryTest, WithoutAFileNothingIsRemembered) {
  PoseMemory memory("", 3);
  memory.remember(first_);
  EXPECT_EQ(memory.recall().size(), 0);
}

TEST_F(PoseMemoryTest, TheLastCounts) {
  PoseMemory memory(path_, 3);
  for (int i = 0; i < 5; ++i) {
    memory.remember(first_);
    EXPECT_EQ(memory.recall(), first_);
    memory.remember(second_);
    EXPECT_EQ(memory.recall(), second_);
  }
}

TEST_F(PoseMemoryTest, SurvivesKill) {
  const pid_t child = fork();
  if (child == 0) {
    PoseMemory memory(path_, 3);
    memory.remember(first_);
    memory.remember(second_);
    std::raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  PoseMemory successor(path_, 3);
  EXPECT_EQ(successor.recall(), second_);
  successor.remember(first_);
  EXPECT_EQ(successor.recall(), first_) << "goes on counting";
}

TEST_F(PoseMemoryTest, OfAnotherArmIsNotTaken) {
  PoseMemory(path_, 3).remember(first_);
  EXPECT_EQ(PoseMemory(path_, 4).recall().size(), 0);
}

TEST_F(PoseMemoryTest, FolderIsToldInASentence) {
  const std::string folder = std::filesystem::temp_directory_path().string();
  try {
    PoseMemory memory(folder, 3);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), folder + ": the arm's pose cannot be remembered there: Is a directory");
  }
}

}  // namespace
}  // namespace hecaton::services
