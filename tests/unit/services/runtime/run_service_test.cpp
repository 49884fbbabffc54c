// Steps of a service's main(). They act on the whole process, so each test runs in a process of its own.
#include "services/runtime/run_service.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/signal_process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

constexpr int kMostWaiting = 60'000;  // [ms]

bool readable(int fd, int milliseconds) {
  pollfd waiting{fd, POLLIN, 0};
  return poll(&waiting, 1, milliseconds) == 1;
}

/// Sends 'y' when the notifier has taken over the descriptor, then returns each byte that it gets, for ever.
[[noreturn]] void run_child(int exit_pipe, int questions, int answers) {
  start_exit_notifier(exit_pipe);
  const bool handed_over = fcntl(exit_pipe, F_GETFD) == -1;
  std::thread busy([] {
    for (std::atomic<unsigned> work = 0;; ++work) {
    }
  });
  for (char byte = handed_over ? 'y' : 'n'; write(answers, &byte, 1) == 1 && read(questions, &byte, 1) == 1;) {
  }
  std::_Exit(0);
}

class ExitNotifierTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (auto* pipe : {exit_, questions_, answers_}) ASSERT_EQ(pipe2(pipe, O_CLOEXEC), 0);
    child_ = fork();
    if (child_ == 0) {
      close(exit_[0]);
      run_child(exit_[1], questions_[0], answers_[1]);
    }
    close(exit_[1]);
    close(questions_[0]);
    close(answers_[1]);
  }
  void TearDown() override {
    static_cast<void>(test::signal_process(child_, SIGKILL));
    waitpid(child_, nullptr, 0);
    for (const int fd : {exit_[0], questions_[1], answers_[0]}) close(fd);
  }
  char answer() {
    char byte = 0;
    if (readable(answers_[0], kMostWaiting) && read(answers_[0], &byte, 1) != 1) byte = 0;
    return byte;
  }

  int exit_[2];
  int questions_[2];
  int answers_[2];
  pid_t child_ = -1;
};

TEST_F(ExitNotifierTest, ReportsTheEndOfTheProcessAndNothingBefore) {
  EXPECT_EQ(answer(), 'y') << "no other thread of the process has the descriptor";
  EXPECT_EQ(write(questions_[1], "x", 1), 1);
  EXPECT_EQ(answer(), 'x') << "the process still has its other descriptors";
  EXPECT_FALSE(readable(exit_[0], 0));
  ASSERT_TRUE(test::signal_process(child_, SIGKILL));
  ASSERT_TRUE(readable(exit_[0], kMostWaiting));
  char byte = 0;
  EXPECT_EQ(read(exit_[0], &byte, 1), 0);
}

TEST_F(ExitNotifierTest, IsSilentWhileTheProcessIsStopped) {
  EXPECT_EQ(answer(), 'y');
  ASSERT_TRUE(test::signal_process(child_, SIGSTOP));
  int status = 0;
  ASSERT_EQ(waitpid(child_, &status, WUNTRACED), child_);
  ASSERT_TRUE(WIFSTOPPED(status));
  EXPECT_FALSE(readable(exit_[0], 0));
}

/// A value of /proc/self/status [kB]; −1: not found.
long status_kb(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(key + ":")) return std::strtol(line.c_str() + key.size() + 1, nullptr, 10);
  }
  return -1;
}

bool may_lock() {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) return true;
  constexpr unsigned long kIpcLock = 1UL << 14U;
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("CapEff:")) return (std::strtoul(line.c_str() + 7, nullptr, 16) & kIpcLock) != 0;
  }
  return false;
}

TEST(MemoryLockDeathTest, LocksPresentAndLaterMemoryWhereAllowed) {
  EXPECT_EXIT(
      {
        const long before = status_kb("RssFile");
        lock_memory();
        const bool read = status_kb("RssFile") > before;
        const long locked = status_kb("VmLck");
        const void* later = std::malloc(64U << 20U);  // a new mapping, never touched
        const bool follows = later != nullptr && status_kb("VmLck") >= locked + (64 << 10);
        std::exit(!read ? 1 : may_lock() && !(locked > 0 && follows) ? 2 : 0);
      },
      ::testing::ExitedWithCode(0), "");
}

TEST(RunServiceTest, SaysThatAServiceGetsNoMoreMemory) {
  const std::array<const char*, 2> words{"service", "cell.yaml"};
  testing::internal::CaptureStderr();
  const int code = run_service(2, words.data(), "a service", Subject::kCell,
                               [](const ServiceOptions&, ShutdownSignal&) { throw std::bad_alloc(); });
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, static_cast<int>(ExitCode::kNoMemory));
  EXPECT_NE(text.find("no more memory: supervision.memory_limit"), std::string::npos) << text;
}

TEST(PrivateFilesDeathTest, AreOnlyForTheUserOfTheService) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("file");
  EXPECT_EXIT(
      {
        ::umask(0);
        keep_files_private();
        std::ofstream(path) << "of the run";
        std::exit(0);
      },
      ::testing::ExitedWithCode(0), "");
  EXPECT_EQ(std::filesystem::status(path).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

}  // namespace
}  // namespace hecaton::services
