#include "services/agent/child_process.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

/// Where the child finds its end of the socket for signs of life.
constexpr int kAliveFd = 3;

[[noreturn]] void fail(const std::filesystem::path& program, int error) {
  throw std::runtime_error(start_failure(program, error));
}

/// Told through a pipe that exec closes: why the child did not become the program.
[[noreturn]] void report_and_leave(int pipe) {
  const int error = errno;
  [[maybe_unused]] const auto written = write(pipe, &error, sizeof error);
  _exit(127);
}

void reset_signals() {
  struct sigaction fresh {};
  fresh.sa_handler = SIG_DFL;
  for (int number = 1; number < NSIG; ++number) sigaction(number, &fresh, nullptr);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

/// In the child between fork and exec, where other threads' locks may be held: system calls only.
[[noreturn]] void become(const char* program, char* const* arguments, const char* log, pid_t parent, int pipe,
                         int alive) {
  reset_signals();
  const int report = fcntl(pipe, F_DUPFD_CLOEXEC, kAliveFd + 1);  // neither is where the other shall be
  if (report < 0) report_and_leave(pipe);
  pipe = report;
  setpgid(0, 0);  // the terminal's Ctrl-C is ours to pass on, in order
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) report_and_leave(pipe);
  if (getppid() != parent) _exit(127);  // it died before it could have taken us along
  const int nothing = open("/dev/null", O_RDONLY);
  if (nothing < 0 || dup2(nothing, STDIN_FILENO) < 0) report_and_leave(pipe);
  if (*log != '\0') {
    const int file = open(log, O_WRONLY | O_CREAT | O_APPEND, 0644);
    if (file < 0 || dup2(file, STDOUT_FILENO) < 0 || dup2(file, STDERR_FILENO) < 0) report_and_leave(pipe);
  }
  // dup3 refuses to leave a descriptor where it is, with its flags: so a copy of it is put there.
  if (alive >= 0) {
    const int copy = fcntl(alive, F_DUPFD_CLOEXEC, kAliveFd + 1);
    if (copy < 0 || dup2(copy, kAliveFd) < 0) report_and_leave(pipe);
  }
  // The pipe stays until exec: all descriptors of ours are closed by it.
  const unsigned first = alive >= 0 ? kAliveFd + 1 : kAliveFd;
  if (syscall(SYS_close_range, first, ~0U, CLOSE_RANGE_CLOEXEC) != 0) report_and_leave(pipe);
  execv(program, arguments);
  report_and_leave(pipe);
}

}  // namespace

std::string start_failure(const std::filesystem::path& program, int error) {
  return program.string() + " cannot be started: " + std::strerror(error);
}

ChildProcess::ChildProcess(const ChildCommand& command) {
  const std::string program = command.program.string();
  const std::string log = command.log.string();
  std::vector<std::string> words{program};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  if (command.tells_alive) words.insert(words.end(), {"--alive-fd", std::to_string(kAliveFd)});
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  int sockets[2] = {-1, -1};
  if (command.tells_alive && socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0) {
    fail(command.program, errno);
  }
  alive_ = sockets[0];
  int pipe[2];
  if (pipe2(pipe, O_CLOEXEC) != 0) {
    const int error = errno;
    if (sockets[1] >= 0) close(sockets[1]);
    close_own();
    fail(command.program, error);
  }
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) become(program.c_str(), arguments.data(), log.c_str(), parent, pipe[1], sockets[1]);
  const int fork_error = errno;
  close(pipe[1]);
  if (sockets[1] >= 0) close(sockets[1]);
  start_ = pipe[0];
  if (pid_ < 0) {
    close_own();
    fail(command.program, fork_error);
  }
  // Nobody else reaps it, so the number is still its own.
  pidfd_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  if (pidfd_ < 0) {
    const int error = errno;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    close_own();
    fail(command.program, error);
  }
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      pidfd_(std::exchange(other.pidfd_, -1)),
      alive_(std::exchange(other.alive_, -1)),
      start_(std::exchange(other.start_, -1)),
      start_error_(other.start_error_),
      end_(other.end_) {}

ChildProcess::~ChildProcess() {
  if (pidfd_ >= 0 && !end_) {
    signal(SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  close_own();
}

void ChildProcess::close_own() {
  if (pidfd_ >= 0) close(pidfd_);
  if (alive_ >= 0) close(alive_);
  if (start_ >= 0) close(start_);
}

std::optional<int> ChildProcess::poll_start() {
  if (start_ < 0) return start_error_;
  pollfd known{start_, POLLIN, 0};
  if (poll(&known, 1, 0) <= 0) return std::nullopt;
  int error = 0;
  if (read(start_, &error, sizeof error) == sizeof error) start_error_ = error;
  close(std::exchange(start_, -1));
  return start_error_;
}

bool ChildProcess::told_alive() {
  bool told = false;
  char bytes[64];
  while (alive_ >= 0 && recv(alive_, bytes, sizeof bytes, MSG_DONTWAIT) > 0) told = true;
  return told;
}

void ChildProcess::signal(int number) const {
  if (!end_) static_cast<void>(syscall(SYS_pidfd_send_signal, pidfd_, number, nullptr, 0));
}

std::optional<ChildEnd> ChildProcess::poll_end() {
  if (end_) return end_;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
  if (WIFSIGNALED(status)) {
    end_ = ChildEnd{-1, WTERMSIG(status)};
  } else {
    end_ = ChildEnd{WEXITSTATUS(status), 0};
  }
  return end_;
}

}  // namespace hecaton::services
