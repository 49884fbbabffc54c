#include "services/agent/child_process.hpp"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
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

#include "services/runtime/urgency.hpp"

namespace hecaton::services {
namespace {

/// Where the child finds its end of the socket for signs of life, and of the pipe that its end closes.
constexpr int kAliveFd = 3;
constexpr int kLifeFd = 4;
constexpr int kFirstOther = 5;

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

/// What a child tells us by: it writes at the end, we read at the beginning. Closes what nobody has taken.
struct Line {
  Line() = default;
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;
  ~Line() {
    if (begin >= 0) close(begin);
    if (end >= 0) close(end);
  }
  bool open_pipe() {
    int ends[2];
    return pipe2(ends, O_CLOEXEC) == 0 && keep(ends);
  }
  bool open_socket() {
    int ends[2];
    return socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0 && keep(ends);
  }

  int begin = -1;
  int end = -1;

 private:
  bool keep(const int* ends) {
    begin = ends[0];
    end = ends[1];
    return true;
  }
};

/// The ends of the lines that are the child's; below 0: none.
struct Ties {
  int start = -1;
  int alive = -1;
  int life = -1;
};

/// Of this descriptor; below 0: there is none.
int out_of_the_way(int descriptor, int pipe) {
  if (descriptor < 0) return descriptor;
  const int copy = fcntl(descriptor, F_DUPFD_CLOEXEC, kFirstOther);
  if (copy < 0) report_and_leave(pipe);
  return copy;
}

/// In the child between fork and exec, where other threads' locks may be held: system calls only.
[[noreturn]] void become(const char* program, char* const* arguments, const char* log, pid_t parent, Ties ties) {
  reset_signals();
  start_behind_loops();
  // All are out of the way of each other's places before one is put there.
  const int pipe = fcntl(ties.start, F_DUPFD_CLOEXEC, kFirstOther);
  if (pipe < 0) report_and_leave(ties.start);
  setpgid(0, 0);  // the terminal's Ctrl-C is ours to pass on, in order
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) report_and_leave(pipe);
  if (getppid() != parent) _exit(127);  // it died before it could have taken us along
  const int nothing = open("/dev/null", O_RDONLY);
  if (nothing < 0 || dup2(nothing, STDIN_FILENO) < 0) report_and_leave(pipe);
  if (*log != '\0') {
    const int file = open(log, O_WRONLY | O_CREAT | O_APPEND, 0644);
    if (file < 0 || dup2(file, STDOUT_FILENO) < 0 || dup2(file, STDERR_FILENO) < 0) report_and_leave(pipe);
  }
  const int alive = out_of_the_way(ties.alive, pipe);
  const int life = out_of_the_way(ties.life, pipe);
  // Exec closes all descriptors of ours, the pipe, too; what is put into its place now stays.
  if (syscall(SYS_close_range, kAliveFd, ~0U, CLOSE_RANGE_CLOEXEC) != 0) report_and_leave(pipe);
  if (alive >= 0 && dup2(alive, kAliveFd) < 0) report_and_leave(pipe);
  if (life >= 0 && dup2(life, kLifeFd) < 0) report_and_leave(pipe);
  execv(program, arguments);
  report_and_leave(pipe);
}

ChildEnd end_of(int status) {
  if (WIFSIGNALED(status)) return {-1, WTERMSIG(status)};
  return {WEXITSTATUS(status), 0};
}

/// Of /proc/PID/stat, proc(5), by their numbers there less the two before the state.
constexpr int kState = 0;
constexpr int kExitCode = 49;

// As wait(2) has it: how the kernel has begun to end the process. Nothing in there tells whether it has begun; but who
// returns 0 without being asked is worth no haste, and who stands still is not ending.
std::optional<ChildEnd> announced_end(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  std::getline(file, line);
  const std::size_t name_end = line.rfind(") ");
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream rest(line.substr(name_end + 2));
  const std::vector<std::string> fields{std::istream_iterator<std::string>(rest), {}};
  if (fields.size() <= kExitCode) return std::nullopt;
  const char state = fields[kState].front();
  const int status = std::atoi(fields[kExitCode].c_str());
  if (state == 'T' || state == 't' || status == 0) return std::nullopt;
  return end_of(status);
}

/// Who was started with SIGCHLD ignored has no children whose end it could learn.
void keep_children() {
  struct sigaction action {};
  if (sigaction(SIGCHLD, nullptr, &action) != 0 || action.sa_handler != SIG_IGN) return;
  action.sa_handler = SIG_DFL;
  sigaction(SIGCHLD, &action, nullptr);
}

}  // namespace

std::string start_failure(const std::filesystem::path& program, int error) {
  return program.string() + " cannot be started: " + std::strerror(error);
}

ChildProcess::ChildProcess(const ChildCommand& command) {
  keep_children();
  const std::string program = command.program.string();
  const std::string log = command.log.string();
  std::vector<std::string> words{program};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  if (command.tells_alive) words.insert(words.end(), {"--alive-fd", std::to_string(kAliveFd)});
  if (command.tells_end) words.insert(words.end(), {"--life-fd", std::to_string(kLifeFd)});
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  Line start;
  Line alive;
  Line life;
  const bool open =
      start.open_pipe() && (!command.tells_alive || alive.open_socket()) && (!command.tells_end || life.open_pipe());
  if (!open) fail(command.program, errno);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) become(program.c_str(), arguments.data(), log.c_str(), parent, {start.end, alive.end, life.end});
  if (pid_ < 0) fail(command.program, errno);
  // Nobody else reaps it, so the number is still its own.
  pidfd_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  if (pidfd_ < 0) {
    const int error = errno;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    fail(command.program, error);
  }
  start_ = std::exchange(start.begin, -1);
  alive_ = std::exchange(alive.begin, -1);
  life_ = std::exchange(life.begin, -1);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      pidfd_(std::exchange(other.pidfd_, -1)),
      alive_(std::exchange(other.alive_, -1)),
      life_(std::exchange(other.life_, -1)),
      start_(std::exchange(other.start_, -1)),
      start_error_(other.start_error_),
      end_(other.end_) {}

ChildProcess::~ChildProcess() {
  signal(SIGKILL);
  if (pid_ > 0) waitpid(pid_, nullptr, 0);
  close_own();
}

void ChildProcess::close_own() {
  if (pidfd_ >= 0) close(pidfd_);
  if (alive_ >= 0) close(alive_);
  if (life_ >= 0) close(life_);
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
  if (pid_ > 0 && !end_) static_cast<void>(syscall(SYS_pidfd_send_signal, pidfd_, number, nullptr, 0));
}

std::optional<ChildEnd> ChildProcess::poll_doom() {
  if (life_ < 0) return std::nullopt;
  pollfd gone{life_, POLLIN, 0};
  if (poll(&gone, 1, 0) <= 0) return std::nullopt;
  close(std::exchange(life_, -1));  // it has nothing more to say
  return announced_end(pid_);
}

std::optional<ChildEnd> ChildProcess::poll_end() {
  if (end_) return end_;
  siginfo_t info{};
  if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != pid_) {
    return std::nullopt;
  }
  end_ = info.si_code == CLD_EXITED ? ChildEnd{info.si_status, 0} : ChildEnd{-1, info.si_status};
  return end_;
}

pid_t ChildProcess::let_go() {
  return std::exchange(pid_, -1);
}

}  // namespace hecaton::services
