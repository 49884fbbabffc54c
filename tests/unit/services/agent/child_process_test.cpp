// Children are small shell programs, so that what they see of us can be asked of the kernel itself.

#include "services/agent/child_process.hpp"

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <semaphore>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/runtime/thread_priority.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

constexpr int kMostWaiting = 60'000;  // [ms]

class ChildProcessTest : public ::testing::Test {
 protected:
  ChildProcess shell(const std::string& script) {
    return ChildProcess({"/bin/sh", {"-c", script}, folder_.path("log")});
  }
  static std::optional<ChildEnd> await_end(ChildProcess& child) {
    pollfd ended{child.fd(), POLLIN, 0};
    EXPECT_EQ(poll(&ended, 1, kMostWaiting), 1);
    return child.poll_end();
  }
  static std::optional<int> await_start(ChildProcess& child) {
    pollfd known{child.start_fd(), POLLIN, 0};
    EXPECT_EQ(poll(&known, 1, kMostWaiting), 1);
    return child.poll_start();
  }
  std::string log() {
    std::ifstream file(folder_.path("log"));
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  test::TemporaryFolder folder_;
};

TEST_F(ChildProcessTest, ReportsItsExitCode) {
  auto child = shell("exit 3");
  const auto end = await_end(child);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 3);
  EXPECT_EQ(end->signal_number, 0);
}

TEST_F(ChildProcessTest, ReportsTheSignalThatEndedIt) {
  auto child = shell("exec sleep 600");
  EXPECT_FALSE(child.poll_end());
  child.signal(SIGKILL);
  const auto end = await_end(child);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, -1);
  EXPECT_EQ(end->signal_number, SIGKILL);
}

TEST_F(ChildProcessTest, AnnouncesItsEndWhenTheKernelBegins) {
  ChildProcess child({"/bin/sh", {"-c", "kill -KILL $$"}, folder_.path("log"), false, true});
  pollfd closed{child.exit_fd(), POLLIN, 0};
  ASSERT_EQ(poll(&closed, 1, kMostWaiting), 1);
  const auto announced = child.poll_announced_end();
  ASSERT_TRUE(announced);
  EXPECT_EQ(announced->signal_number, SIGKILL);
  EXPECT_LT(child.exit_fd(), 0);
  EXPECT_FALSE(child.poll_announced_end()) << "once";
  const auto end = await_end(child);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->signal_number, SIGKILL);
}

TEST_F(ChildProcessTest, AnnouncesNoEndWhenItOnlyClosesItsExitPipe) {
  ChildProcess child({"/bin/sh", {"-c", "exec 4>&-; exec sleep 600"}, folder_.path("log"), true, true});
  pollfd closed{child.exit_fd(), POLLIN, 0};
  ASSERT_EQ(poll(&closed, 1, kMostWaiting), 1);
  EXPECT_FALSE(child.poll_announced_end());
  EXPECT_LT(child.exit_fd(), 0) << "it is polled once only";
  EXPECT_FALSE(child.poll_end());
}

TEST_F(ChildProcessTest, StartsWithLowerPriorityThanARealTimeParent) {
  ChildProcess* child = nullptr;
  bool first = false;
  // The thread that starts a child must outlive it.
  std::binary_semaphore seen(0);
  std::binary_semaphore started(0);
  std::thread urgent([&] {
    sched_param parameters{};
    parameters.sched_priority = static_cast<int>(ThreadPriority::kAgent);
    first = sched_setscheduler(0, SCHED_RR, &parameters) == 0;  // if permitted
    ChildProcess own({"/bin/cut", {"-d", " ", "-f", "40,41", "/proc/self/stat"}, folder_.path("log")});
    child = &own;
    started.release();
    seen.acquire();
  });
  started.acquire();
  await_end(*child);
  const auto urgency =
      std::to_string(static_cast<int>(ThreadPriority::kStartup)) + " " + std::to_string(SCHED_RR) + "\n";
  EXPECT_EQ(log(), first ? urgency : "0 0\n");
  seen.release();
  urgent.join();
}

TEST_F(ChildProcessTest, ReportsItsEndWhenTheParentInheritedAnIgnoredSigchld) {
  struct sigaction before {};
  struct sigaction ignored {};
  ignored.sa_handler = SIG_IGN;
  ASSERT_EQ(sigaction(SIGCHLD, &ignored, &before), 0);
  auto child = shell("exit 3");
  const auto end = await_end(child);
  sigaction(SIGCHLD, &before, nullptr);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 3);
}

TEST_F(ChildProcessTest, LogsToItsFile) {
  auto child = shell("echo out; echo err >&2");
  await_end(child);
  EXPECT_EQ(log(), "out\nerr\n");
  auto next = shell("echo more");
  await_end(next);
  EXPECT_EQ(log(), "out\nerr\nmore\n");
  EXPECT_EQ(std::filesystem::status(folder_.path("log")).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

// tail keeps all that it reads of a pipe without lines.
TEST_F(ChildProcessTest, EndsWhenItAllocatesMoreThanItMay) {
  ChildCommand command{"/bin/tail", {"/dev/zero"}, folder_.path("log")};
  command.most_data = 50'000'000;
  ChildProcess bounded(command);
  const auto end = await_end(bounded);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 1) << log();
  EXPECT_EQ(end->signal_number, 0) << "the kernel refuses memory and kills nothing";

  auto unbounded = shell("head -c 100000000 /dev/zero | tail -n 1 | wc -c");
  const auto ended = await_end(unbounded);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0);
  EXPECT_NE(log().find("100000000"), std::string::npos) << log();
}

TEST_F(ChildProcessTest, ReportsAMissingProgramAsASentence) {
  ChildProcess child({"/no/such/program", {}, {}});
  const auto error = await_start(child);
  ASSERT_TRUE(error);
  EXPECT_EQ(start_failure("/no/such/program", *error), "/no/such/program cannot be started: No such file or directory");
  EXPECT_TRUE(await_end(child));
}

TEST_F(ChildProcessTest, ReportsThatItsProgramRuns) {
  auto child = shell("exec sleep 600");
  EXPECT_EQ(await_start(child), 0);
  EXPECT_LT(child.start_fd(), 0);
  EXPECT_EQ(child.poll_start(), 0);  // again
}

TEST_F(ChildProcessTest, InheritsNoSignalMaskAndNoIgnoredSignals) {
  sigset_t blocked;
  sigset_t before;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &blocked, &before);
  const auto handler = std::signal(SIGPIPE, SIG_IGN);
  ChildProcess child({"/bin/grep", {"-E", "^Sig(Blk|Ign):", "/proc/self/status"}, folder_.path("log")});
  await_end(child);
  std::signal(SIGPIPE, handler);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  EXPECT_EQ(log(), "SigBlk:\t0000000000000000\nSigIgn:\t0000000000000000\n");
}

TEST_F(ChildProcessTest, InheritsNoDescriptors) {
  const int stray = open("/dev/null", O_RDONLY);  // without O_CLOEXEC, as a careless library would
  ASSERT_GE(stray, 0);
  // ls itself opens the folder it lists: descriptor 3.
  ChildProcess child({"/bin/ls", {"/proc/self/fd"}, folder_.path("log")});
  await_end(child);
  close(stray);
  EXPECT_EQ(log(), "0\n1\n2\n3\n");
}

// A process that cannot be started is retried for ever, so a failed start must not leak a descriptor.
TEST_F(ChildProcessTest, LeaksNoDescriptorWhenThereAreTooFew) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit few{64, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  std::vector<int> taken;
  for (int fd = dup(STDERR_FILENO); fd >= 0; fd = dup(STDERR_FILENO)) taken.push_back(fd);
  for (std::size_t spare = 0; spare < 6; ++spare) {  // two for each of its three channels
    for (std::size_t i = 0; i < spare; ++i) close(taken.at(taken.size() - 1 - i));
    EXPECT_THROW(ChildProcess({"/bin/true", {}, {}, true, true}), std::runtime_error) << spare;
    for (std::size_t i = 0; i < spare; ++i) EXPECT_GE(dup(STDERR_FILENO), 0) << i << " of " << spare;
  }
  for (const int fd : taken) close(fd);
  setrlimit(RLIMIT_NOFILE, &before);
}

TEST_F(ChildProcessTest, HasAnEmptyStdin) {
  auto child = shell("cat");
  const auto end = await_end(child);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 0);
}

TEST_F(ChildProcessTest, IsKilledWithItsObject) {
  pid_t pid = 0;
  {
    auto child = shell("exec sleep 600");
    pid = child.pid();
  }
  EXPECT_EQ(kill(pid, 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

// A process between the test and the child starts the child, sends its pid, and is killed.
TEST_F(ChildProcessTest, IsKilledWithItsParent) {
  int told[2];
  ASSERT_EQ(pipe(told), 0);
  const pid_t middle = fork();
  ASSERT_GE(middle, 0);
  if (middle == 0) {
    auto child = shell("exec sleep 600");
    const pid_t its_pid = child.pid();
    if (await_start(child) == 0 && write(told[1], &its_pid, sizeof its_pid) == sizeof its_pid) pause();
    _exit(1);
  }
  pid_t pid = 0;
  ASSERT_EQ(read(told[0], &pid, sizeof pid), static_cast<ssize_t>(sizeof pid));
  close(told[0]);
  close(told[1]);
  // This process reaps the orphan. Otherwise it would stay a zombie of the container's init process.
  ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0);
  kill(middle, SIGKILL);
  ASSERT_EQ(waitpid(middle, nullptr, 0), middle);
  int status = 0;
  ASSERT_EQ(waitpid(pid, &status, 0), pid);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

}  // namespace
}  // namespace hecaton::services
