#pragma once
/// Processes of a test: output, exit code and end.

#include <chrono>
#include <csignal>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::test {

using namespace std::chrono_literals;

/// Ends a test that hangs. Much longer than a busy machine needs.
constexpr auto kPatience = 120s;

/// A process that is no child of the test.
class Watched {
 public:
  explicit Watched(pid_t pid) : fd_(static_cast<int>(syscall(SYS_pidfd_open, pid, 0))) {}
  ~Watched() {
    if (fd_ >= 0) close(fd_);
  }
  Watched(Watched&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Watched& operator=(Watched&&) = delete;
  /// The process ran when the object was made.
  [[nodiscard]] bool found() const { return fd_ >= 0; }
  [[nodiscard]] bool wait_for_end(std::chrono::milliseconds timeout = kPatience) const {
    pollfd descriptor{fd_, POLLIN, 0};
    return fd_ < 0 || poll(&descriptor, 1, static_cast<int>(timeout.count())) > 0;
  }

 private:
  int fd_;
};

/// A child process; it is killed when the test ends.
class Process {
 public:
  enum class Stderr { kPipe, kTerminal };
  explicit Process(const std::vector<std::string>& words, Stderr stderr_is = Stderr::kPipe) {
    int out[2];
    int err[2];
    if (pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    if (stderr_is == Stderr::kPipe) {
      if (pipe2(err, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    } else {
      if (openpty(&err[0], &err[1], nullptr, nullptr, nullptr) != 0) throw std::runtime_error("no terminal");
      for (const int fd : err) fcntl(fd, F_SETFD, FD_CLOEXEC);
    }
    std::vector<char*> argv;
    std::vector<std::string> copies = words;
    for (std::string& word : copies) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      for (const int number : {SIGINT, SIGTERM}) ::signal(number, SIG_DFL);  // a shell may have them ignored
      dup2(out[1], STDOUT_FILENO);
      dup2(err[1], STDERR_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(out[1]);
    close(err[1]);
    streams_[0] = {out[0], ""};
    streams_[1] = {err[0], ""};
  }
  ~Process() {
    if (!ended_) {
      kill(pid_, SIGTERM);
      static_cast<void>(wait());
    }
    for (const Stream& stream : streams_) close(stream.fd);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  void signal(int number) const { kill(pid_, number); }

  /// Reads until `text` was printed on stderr (stdout) or the stream ends.
  [[nodiscard]] bool wait_for_message(const std::string& text) { return wait_for(streams_[1], text); }
  [[nodiscard]] bool wait_for_output(const std::string& text) { return wait_for(streams_[0], text); }
  [[nodiscard]] const std::string& out() const { return streams_[0].text; }
  [[nodiscard]] const std::string& err() const { return streams_[1].text; }

  /// The exit code, or 128 + the signal that ended it.
  int wait() {
    if (ended_) return code_;
    while (streams_[0].open || streams_[1].open) {
      if (!read_more()) kill(pid_, SIGKILL);
    }
    int status = 0;
    waitpid(pid_, &status, 0);
    ended_ = true;
    code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return code_;
  }

 private:
  struct Stream {
    int fd = -1;
    std::string text;
    bool open = true;
  };

  /// False after kPatience without output.
  bool read_more() {
    pollfd descriptors[2];
    for (int i = 0; i < 2; ++i) descriptors[i] = {streams_[i].open ? streams_[i].fd : -1, POLLIN, 0};
    if (poll(descriptors, 2, static_cast<int>(std::chrono::milliseconds(kPatience).count())) <= 0) return false;
    for (int i = 0; i < 2; ++i) {
      if (descriptors[i].revents == 0) continue;
      char buffer[4096];
      const ssize_t size = read(streams_[i].fd, buffer, sizeof buffer);
      if (size > 0) streams_[i].text.append(buffer, static_cast<std::size_t>(size));
      if (size <= 0) streams_[i].open = false;
    }
    return true;
  }

  bool wait_for(Stream& stream, const std::string& text) {
    while (stream.text.find(text) == std::string::npos) {
      if (!stream.open || !read_more()) return false;
    }
    return true;
  }

  pid_t pid_ = -1;
  Stream streams_[2];
  bool ended_ = false;
  int code_ = -1;
};

struct Ran {
  int code;
  std::string out;
  std::string err;
};

/// Runs hecaton until it ends.
inline Ran run_hecaton(std::vector<std::string> words) {
  words.insert(words.begin(), std::string(HECATON_BIN_DIR) + "/hecaton");
  Process process(words);
  const int code = process.wait();
  return {code, process.out(), process.err()};
}

}  // namespace hecaton::test
