// A process that holds a life line, seen from who has its other end.

#include "services/runtime/life_line.hpp"

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/signal_process.hpp"

namespace hecaton::services {
namespace {

constexpr int kMostWaiting = 60'000;  // [ms]

bool readable(int fd, int milliseconds) {
  pollfd waiting{fd, POLLIN, 0};
  return poll(&waiting, 1, milliseconds) == 1;
}

/// Tells by a byte what is as it should be, and then by one more for each that it gets, for ever.
[[noreturn]] void live(int life, int questions, int answers) {
  hold_life_line(life);
  const bool handed_over = fcntl(life, F_GETFD) == -1;
  std::thread busy([] {
    for (std::atomic<unsigned> work = 0;; ++work) {
    }
  });
  for (char byte = handed_over ? 'y' : 'n'; write(answers, &byte, 1) == 1 && read(questions, &byte, 1) == 1;) {
  }
  std::_Exit(0);
}

class LifeLineTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (auto* line : {life_, questions_, answers_}) ASSERT_EQ(pipe2(line, O_CLOEXEC), 0);
    child_ = fork();
    if (child_ == 0) {
      close(life_[0]);
      live(life_[1], questions_[0], answers_[1]);
    }
    close(life_[1]);
    close(questions_[0]);
    close(answers_[1]);
  }
  void TearDown() override {
    static_cast<void>(test::signal_process(child_, SIGKILL));
    waitpid(child_, nullptr, 0);
    for (const int fd : {life_[0], questions_[1], answers_[0]}) close(fd);
  }
  char answer() {
    char byte = 0;
    if (readable(answers_[0], kMostWaiting) && read(answers_[0], &byte, 1) != 1) byte = 0;
    return byte;
  }

  int life_[2];
  int questions_[2];
  int answers_[2];
  pid_t child_ = -1;
};

TEST_F(LifeLineTest, EndsWithTheProcessAndNotBefore) {
  EXPECT_EQ(answer(), 'y') << "nobody else in the process has it";
  EXPECT_EQ(write(questions_[1], "x", 1), 1);
  EXPECT_EQ(answer(), 'x') << "and the process still has everything else";
  EXPECT_FALSE(readable(life_[0], 0));
  ASSERT_TRUE(test::signal_process(child_, SIGKILL));
  ASSERT_TRUE(readable(life_[0], kMostWaiting));
  char byte = 0;
  EXPECT_EQ(read(life_[0], &byte, 1), 0);
}

TEST_F(LifeLineTest, LastsWhileTheProcessStandsStill) {
  EXPECT_EQ(answer(), 'y');
  ASSERT_TRUE(test::signal_process(child_, SIGSTOP));
  int status = 0;
  ASSERT_EQ(waitpid(child_, &status, WUNTRACED), child_);
  ASSERT_TRUE(WIFSTOPPED(status));
  EXPECT_FALSE(readable(life_[0], 0));
}

}  // namespace
}  // namespace hecaton::services
