#include "services/agent/run_folder.hpp"

#include <cstdlib>
#include <fstream>
#include <optional>
#include <stdexcept>

#include <gtest/gtest.h>
#include <linux/magic.h>
#include <sys/statfs.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

class RunFolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* value = std::getenv("TMPDIR")) before_ = value;
    ::unsetenv("TMPDIR");
  }
  void TearDown() override { before_ ? ::setenv("TMPDIR", before_->c_str(), 1) : ::unsetenv("TMPDIR"); }

 private:
  std::optional<std::string> before_;
};

TEST_F(RunFolderTest, IsInMemorySoThatNobodyWaitsForADisk) {
  if (::access("/dev/shm", W_OK | X_OK) != 0) GTEST_SKIP() << "this machine has no /dev/shm";
  const RunFolder folder("cell");
  struct statfs about {};
  ASSERT_EQ(::statfs(folder.path().c_str(), &about), 0);
  EXPECT_EQ(about.f_type, TMPFS_MAGIC) << folder.path();
}

TEST_F(RunFolderTest, IsWhereTmpdirSaysAndGoneAfterwards) {
  const auto parent = std::filesystem::temp_directory_path() / ("run_folder_test-" + std::to_string(::getpid()));
  std::filesystem::create_directory(parent);
  ::setenv("TMPDIR", parent.c_str(), 1);
  {
    const RunFolder folder("cell");
    EXPECT_EQ(folder.path().parent_path(), parent);
    std::ofstream(folder.path() / "memory") << "kept";
  }
  EXPECT_TRUE(std::filesystem::is_empty(parent));
  std::filesystem::remove(parent);
}

TEST_F(RunFolderTest, CannotBeWhereNothingMayBeMade) {
  ::setenv("TMPDIR", "/proc", 1);
  try {
    const RunFolder folder("cell");
    FAIL() << folder.path();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "no folder for the run can be made in /proc: set TMPDIR to one that may");
  }
}

}  // namespace
}  // namespace hecaton::services
