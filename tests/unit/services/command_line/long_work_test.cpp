#include "services/command_line/long_work.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

namespace hecaton::services::cli {
namespace {

TEST(Interruption, KeepsTheFirstSignal) {
  Interruption interruption;
  EXPECT_FALSE(interruption.requested());
  EXPECT_FALSE(interruption.after(1, 2, "tasks"));
  raise(SIGTERM);
  raise(SIGTERM);  // `timeout` signals twice
  EXPECT_EQ(interruption.signal(), SIGTERM);
  const auto interrupted = interruption.after(12, 100, "tasks");
  ASSERT_TRUE(interrupted);
  EXPECT_EQ(interrupted->text(), "interrupted by SIGTERM: 12 of 100 tasks done");
  EXPECT_EQ(static_cast<int>(interrupted->exit_code()), 143);
  EXPECT_EQ(to_json(interrupted), (Json{{"signal", "SIGTERM"}, {"done", 12}, {"asked", 100}, {"unit", "tasks"}}));
  EXPECT_TRUE(to_json(std::optional<Interrupted>()).is_null());
}

TEST(InterruptionDeathTest, SecondSignalEndsTheProcess) {
  EXPECT_EXIT(
      {
        std::signal(SIGINT, SIG_DFL);  // a shell's background job has it ignored
        Interruption interruption;
        while (true) raise(SIGINT);
      },
      testing::ExitedWithCode(130), "");
}

TEST(Interruption, LeavesAnIgnoredSignalIgnored) {
  const auto before = std::signal(SIGINT, SIG_IGN);
  {
    Interruption interruption;
    raise(SIGINT);
    EXPECT_FALSE(interruption.requested());
  }
  std::signal(SIGINT, before);
}

/// The reading end of what a Progress writes.
class Reader {
 public:
  explicit Reader(bool terminal) {
    int ends[2];
    if ((terminal ? openpty(&ends[0], &ends[1], nullptr, nullptr, nullptr) : pipe(ends)) != 0) std::abort();
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    read_ = ends[0];
    stream_ = fdopen(ends[1], "w");
  }
  ~Reader() {
    std::fclose(stream_);
    close(read_);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  [[nodiscard]] std::FILE* stream() const { return stream_; }
  /// What has been written so far.
  const std::string& text() {
    char buffer[1024];
    for (ssize_t size = 0; (size = read(read_, buffer, sizeof buffer)) > 0;) {
      text_.append(buffer, static_cast<std::size_t>(size));
    }
    return text_;
  }

 private:
  int read_;
  std::FILE* stream_;
  std::string text_;
};

TEST(Progress, RewritesOneLineOfATerminalAndWritesNothingElsewhere) {
  setenv("TERM", "xterm", 1);
  Reader terminal(true);
  Reader pipe(false);
  {
    Progress on_terminal(Progress::Elsewhere::kNothing, terminal.stream());
    Progress in_pipe(Progress::Elsewhere::kNothing, pipe.stream());
    for (double done = 0.0; terminal.text().find(" left") == std::string::npos; done += 1e-6) {
      on_terminal.show("work", std::min(50.0, done), 100.0, "tasks", "a note");
      in_pipe.show("work", std::min(50.0, done), 100.0, "tasks", "a note");
    }
  }
  EXPECT_EQ(terminal.text().find("\rwork ["), 0U) << terminal.text();
  EXPECT_NE(terminal.text().find(" of 100 tasks, "), std::string::npos) << terminal.text();
  EXPECT_TRUE(terminal.text().ends_with("\r\x1b[K")) << "the line is cleared at the end: " << terminal.text();
  EXPECT_EQ(terminal.text().find('\n'), std::string::npos) << terminal.text();
  EXPECT_EQ(pipe.text(), "");
}

}  // namespace
}  // namespace hecaton::services::cli
