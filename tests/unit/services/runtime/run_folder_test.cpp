#include "services/runtime/run_folder.hpp"

#include <cstdlib>
#include <fstream>
#include <optional>
#include <stdexcept>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <unistd.h>

#include "planner/model/source_file.hpp"

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;

const RunName kRun{"cell", 42, "pc1"};

std::string refusal(const RunName& run) {
  try {
    const RunFolder folder(run, "files");
    return "not refused";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

/// Each test has its own parent folder of runs.
class RunFolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* value = std::getenv("TMPDIR")) before_ = value;
    std::string name = (fs::temp_directory_path() / "run_folder_test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    parent_ = name;
    ::setenv("TMPDIR", name.c_str(), 1);
  }
  void TearDown() override {
    before_ ? ::setenv("TMPDIR", before_->c_str(), 1) : ::unsetenv("TMPDIR");
    fs::remove_all(parent_);
  }
  /// Leaves a folder as a killed agent does.
  static fs::path killed(const RunName& run, const std::string& origin) {
    RunFolder folder(run, origin);
    folder.keep();
    std::ofstream(folder.path() / "checkpoint") << "kept";
    return folder.path();
  }
  static void make_old(const fs::path& folder, std::chrono::hours age) {
    timespec times[2]{};
    ASSERT_EQ(::clock_gettime(CLOCK_REALTIME, &times[1]), 0);
    times[1].tv_sec -= std::chrono::seconds(age).count();
    times[0] = times[1];
    ASSERT_EQ(::utimensat(AT_FDCWD, folder.c_str(), times, 0), 0);
  }
  fs::path parent_;

 private:
  std::optional<std::string> before_;
};

TEST_F(RunFolderTest, IsInMemoryByDefault) {
  if (::access("/dev/shm", W_OK | X_OK) != 0) GTEST_SKIP() << "this machine has no /dev/shm";
  ::unsetenv("TMPDIR");
  const RunFolder folder({"run_folder_test-" + std::to_string(::getpid()), 0, "here"}, "files");
  struct statfs about {};
  ASSERT_EQ(::statfs(folder.path().c_str(), &about), 0);
  EXPECT_EQ(about.f_type, TMPFS_MAGIC) << folder.path();
}

TEST_F(RunFolderTest, IsInTmpdirAndRemovedWithARunThatNeverBegan) {
  {
    const RunFolder folder(kRun, "files");
    EXPECT_EQ(folder.path(), parent_ / "hecaton-42-cell@pc1");
    EXPECT_FALSE(folder.resumed());
    std::ofstream(folder.path() / "checkpoint") << "kept";
  }
  EXPECT_TRUE(fs::is_empty(parent_));
}

TEST_F(RunFolderTest, OutlivesAKilledAgentAndIsRemovedWithTheRun) {
  const fs::path path = killed(kRun, "files");
  {
    const RunFolder folder(kRun, "files");  // of an agent that could not begin
    EXPECT_TRUE(folder.resumed());
  }
  {
    RunFolder folder(kRun, "files");
    EXPECT_TRUE(folder.resumed());
    EXPECT_FALSE(folder.discarded());
    EXPECT_EQ(folder.path(), path);
    EXPECT_TRUE(fs::exists(path / "checkpoint"));
    folder.keep();
    folder.end();
  }
  EXPECT_TRUE(fs::is_empty(parent_));
}

TEST_F(RunFolderTest, DiscardsCheckpointsOfOtherFiles) {
  const fs::path path = killed(kRun, "files");
  const RunFolder folder(kRun, "other files");
  EXPECT_FALSE(folder.resumed());
  EXPECT_TRUE(folder.discarded());
  EXPECT_FALSE(fs::exists(path / "checkpoint"));
}

TEST_F(RunFolderTest, DiscardsCheckpointsWhoseRemovalWasInterrupted) {
  const fs::path path = killed(kRun, "files");
  std::ofstream(path / "origin", std::ios::trunc).flush();
  const RunFolder folder(kRun, "files");
  EXPECT_FALSE(folder.resumed());
  EXPECT_FALSE(fs::exists(path / "checkpoint"));
}

TEST_F(RunFolderTest, WithFilesOfSomebodyElseIsRefusedAndStays) {
  const fs::path foreign = parent_ / "hecaton-42-cell@pc1" / "results.csv";
  fs::create_directory(foreign.parent_path());
  std::ofstream(foreign) << "a week of work";
  EXPECT_EQ(refusal(kRun), "the folder of the run, " + foreign.parent_path().string() +
                               ", cannot be used: it holds files that no run has made; set TMPDIR "
                               "to another folder");
  remove_run(kRun);
  make_old(foreign.parent_path(), 2 * RunFolder::kAbandoned);
  { const RunFolder other({"other", 42, "pc1"}, "files"); }
  EXPECT_TRUE(fs::exists(foreign));
}

TEST_F(RunFolderTest, DiscardsAllCheckpointsWhenClean) {
  const fs::path path = killed(kRun, "files");
  const RunFolder folder(kRun, "files", true);
  EXPECT_FALSE(folder.resumed());
  EXPECT_FALSE(folder.discarded());
  EXPECT_FALSE(fs::exists(path / "checkpoint"));
}

TEST_F(RunFolderTest, IsRefusedToASecondAgent) {
  RunFolder folder(kRun, "files");
  folder.keep();
  EXPECT_EQ(refusal(kRun), "host pc1 of cell cell in DDS domain 42 already has an agent on this machine, which holds " +
                               folder.path().string());
  remove_run(kRun);
  EXPECT_TRUE(fs::exists(folder.path()));
}

TEST_F(RunFolderTest, DiffersForOtherHostsDomainsAndCells) {
  const RunFolder folder(kRun, "files");
  const RunFolder host({"cell", 42, "pc2"}, "files");
  const RunFolder domain({"cell", 43, "pc1"}, "files");
  const RunFolder cell({"2-cell", 4, "pc1"}, "files");
  EXPECT_EQ(std::distance(fs::directory_iterator(parent_), fs::directory_iterator()), 4);
}

TEST_F(RunFolderTest, IsNotASymbolicLink) {
  fs::create_directory(parent_ / "elsewhere");
  fs::create_directory_symlink(parent_ / "elsewhere", parent_ / "hecaton-42-cell@pc1");
  EXPECT_EQ(refusal(kRun), "the folder of the run, " + (parent_ / "hecaton-42-cell@pc1").string() +
                               ", cannot be used: it belongs to another user; set TMPDIR to another folder");
}

TEST_F(RunFolderTest, IsRefusedWhereNothingCanBeCreated) {
  for (const auto& [parent, why] :
       {std::pair{"/nonexistent", "No such file or directory"}, std::pair{"/dev/null", "Not a directory"}}) {
    ::setenv("TMPDIR", parent, 1);
    EXPECT_EQ(refusal(kRun), "the folder of the run, " + std::string(parent) +
                                 "/hecaton-42-cell@pc1, cannot be used: " + why + "; set TMPDIR to another folder");
  }
}

TEST_F(RunFolderTest, OfAnAbandonedRunIsRemovedAfterDays) {
  const fs::path old = killed({"old", 42, "pc1"}, "files");
  const fs::path young = killed({"young", 42, "pc1"}, "files");
  RunFolder busy({"busy", 42, "pc1"}, "files");
  busy.keep();
  fs::create_directory(parent_ / "hecaton-logs");
  for (const fs::path& path : {old, busy.path(), parent_ / "hecaton-logs"}) {
    make_old(path, RunFolder::kAbandoned + std::chrono::hours(1));
  }
  make_old(young, RunFolder::kAbandoned - std::chrono::hours(1));
  const RunFolder folder(kRun, "files");
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(young));
  EXPECT_TRUE(fs::exists(busy.path()));
  EXPECT_TRUE(fs::exists(parent_ / "hecaton-logs"));
}

TEST_F(RunFolderTest, OfALivingAgentIsNotAbandoned) {
  RunFolder folder(kRun, "files");
  folder.keep();
  make_old(folder.path(), 2 * RunFolder::kAbandoned);
  folder.touch();
  EXPECT_GT(fs::last_write_time(folder.path()), fs::file_time_type::clock::now() - RunFolder::kAbandoned);
}

TEST_F(RunFolderTest, OfAKilledAgentIsRemovedOnRequest) {
  const fs::path path = killed(kRun, "files");
  remove_run(kRun);
  EXPECT_FALSE(fs::exists(path));
  remove_run(kRun);  // does nothing
}

TEST_F(RunFolderTest, OriginDependsOnTheFilesContents) {
  const fs::path file = parent_ / "cell.yaml";
  std::ofstream(file) << "one";
  planner::SourceFiles sources;
  static_cast<void>(sources.open(file));
  const std::string before = run_origin(sources);
  EXPECT_NE(before.find(file.string()), std::string::npos) << before;
  std::ofstream(file) << "two";
  EXPECT_NE(run_origin(sources), before);
  std::ofstream(file) << "one";
  EXPECT_EQ(run_origin(sources), before);
}

}  // namespace
}  // namespace hecaton::services
