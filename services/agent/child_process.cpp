#include "services/agent/child_process.hpp"

#include <algorithm>
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
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/runtime/thread_priority.hpp"

namespace hecaton::services {
namespace {

/// Descriptors of the child: its end of the heartbeat socket, and of the exit notifier's pipe.
constexpr int kHeartbeatFd = 3;
constexpr int kExitFd = 4;
constexpr int kFirstOther = 5;

[[noreturn]] void fail(const std::filesystem::path& program, int error) {
  throw std::runtime_error(start_failure(program, error));
}

/// Reports errno through a pipe that exec closes: why the child did not become the program.
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

/// A channel from the child: it writes at `end`, the parent reads at `begin`. Closes the ends that were not taken.
struct Channel {
  Channel() = default;
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  ~Channel() {
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

/// The child's ends of its channels; below 0: none.
struct ChildEnds {
  int start = -1;
  int heartbeats = -1;
  int exit = -1;
};

/// A copy of the descriptor above the fixed ones; below 0: there is none.
int moved_up(int descriptor, int pipe) {
  if (descriptor < 0) return descriptor;
  const int copy = fcntl(descriptor, F_DUPFD_CLOEXEC, kFirstOther);
  if (copy < 0) report_and_leave(pipe);
  return copy;
}

/// No limit of the parent is raised.
void limit_data(std::uint64_t most) {
  rlimit limit{};
  if (most == 0 || getrlimit(RLIMIT_DATA, &limit) != 0) return;
  limit.rlim_max = std::min<rlim_t>(limit.rlim_max, most);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_DATA, &limit);
}

/// What the child gets beside its arguments.
struct ChildLimits {
  pid_t parent;
  std::uint64_t most_data;
};

/// Runs in the child between fork and exec. System calls only, because other threads may have held locks at the fork.
[[noreturn]] void become(const char* program, char* const* arguments, const char* log, ChildLimits limits,
                         ChildEnds ends) {
  reset_signals();
  limit_data(limits.most_data);
  lower_child_priority();
  // All descriptors are moved up before one is put into its fixed place.
  const int pipe = fcntl(ends.start, F_DUPFD_CLOEXEC, kFirstOther);
  if (pipe < 0) report_and_leave(ends.start);
  setpgid(0, 0);  // the parent passes Ctrl-C of the terminal on, in order
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) report_and_leave(pipe);
  if (getppid() != limits.parent) _exit(127);  // the parent died before prctl
  const int nothing = open("/dev/null", O_RDONLY);
  if (nothing < 0 || dup2(nothing, STDIN_FILENO) < 0) report_and_leave(pipe);
  if (*log != '\0') {
    const int file = open(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (file < 0 || dup2(file, STDOUT_FILENO) < 0 || dup2(file, STDERR_FILENO) < 0) report_and_leave(pipe);
  }
  const int heartbeats = moved_up(ends.heartbeats, pipe);
  const int exit = moved_up(ends.exit, pipe);
  // exec closes all descriptors above, also the pipe. Those that dup2 makes now stay open.
  if (syscall(SYS_close_range, kHeartbeatFd, ~0U, CLOSE_RANGE_CLOEXEC) != 0) report_and_leave(pipe);
  if (heartbeats >= 0 && dup2(heartbeats, kHeartbeatFd) < 0) report_and_leave(pipe);
  if (exit >= 0 && dup2(exit, kExitFd) < 0) report_and_leave(pipe);
  execv(program, arguments);
  report_and_leave(pipe);
}

ChildEnd end_of(int status) {
  if (WIFSIGNALED(status)) return {-1, WTERMSIG(status)};
  return {WEXITSTATUS(status), 0};
}

/// Indices of fields in /proc/PID/stat after the name, see proc(5).
constexpr int kState = 0;
constexpr int kExitCode = 49;

// The exit status as in wait(2), which the kernel sets when it begins to end the process. The file does not say whether
// that has begun: status 0 and a stopped process count as unknown.
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

/// A process that inherits an ignored SIGCHLD cannot learn how its children end.
void restore_sigchld() {
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
  restore_sigchld();
  const std::string program = command.program.string();
  const std::string log = command.log.string();
  std::vector<std::string> words{program};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  if (command.sends_heartbeats) words.insert(words.end(), {"--heartbeat-fd", std::to_string(kHeartbeatFd)});
  if (command.notifies_exit) words.insert(words.end(), {"--exit-fd", std::to_string(kExitFd)});
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  Channel start;
  Channel heartbeats;
  Channel exit;
  const bool open = start.open_pipe() && (!command.sends_heartbeats || heartbeats.open_socket()) &&
                    (!command.notifies_exit || exit.open_pipe());
  if (!open) fail(command.program, errno);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) {
    become(program.c_str(), arguments.data(), log.c_str(), {parent, command.most_data},
           {start.end, heartbeats.end, exit.end});
  }
  if (pid_ < 0) fail(command.program, errno);
  // Only this process reaps the child, so the pid cannot have been reused.
  pidfd_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  if (pidfd_ < 0) {
    const int error = errno;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    fail(command.program, error);
  }
  start_ = std::exchange(start.begin, -1);
  heartbeats_ = std::exchange(heartbeats.begin, -1);
  exit_ = std::exchange(exit.begin, -1);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      pidfd_(std::exchange(other.pidfd_, -1)),
      heartbeats_(std::exchange(other.heartbeats_, -1)),
      exit_(std::exchange(other.exit_, -1)),
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
  if (heartbeats_ >= 0) close(heartbeats_);
  if (exit_ >= 0) close(exit_);
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

std::uint64_t ChildProcess::memory() const {
  std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
  std::uint64_t size = 0;
  std::uint64_t resident = 0;
  statm >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

bool ChildProcess::take_heartbeats() {
  bool taken = false;
  char bytes[64];
  while (heartbeats_ >= 0 && recv(heartbeats_, bytes, sizeof bytes, MSG_DONTWAIT) > 0) taken = true;
  return taken;
}

void ChildProcess::signal(int number) const {
  if (pid_ > 0 && !end_) static_cast<void>(syscall(SYS_pidfd_send_signal, pidfd_, number, nullptr, 0));
}

std::optional<ChildEnd> ChildProcess::poll_announced_end() {
  if (exit_ < 0) return std::nullopt;
  pollfd closed{exit_, POLLIN, 0};
  if (poll(&closed, 1, 0) <= 0) return std::nullopt;
  close(std::exchange(exit_, -1));
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

pid_t ChildProcess::release() {
  return std::exchange(pid_, -1);
}

Reaper::Reaper() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw std::runtime_error(std::string("no pipe can be created: ") + std::strerror(errno));
  begin_ = ends[0];
  end_ = ends[1];
  thread_ = std::thread([this] { work(); });
}

Reaper::~Reaper() {
  close(end_);
  thread_.join();
  close(begin_);
}

void Reaper::take(pid_t child) const {
  static_cast<void>(TEMP_FAILURE_RETRY(write(end_, &child, sizeof child)));  // the pipe has room for thousands
}

void Reaper::work() const {
  constexpr int kNiceness = 2;
  lower_priority(kNiceness);
  pid_t child = 0;
  // Any thread may get the signals of the process.
  while (TEMP_FAILURE_RETRY(read(begin_, &child, sizeof child)) == sizeof child) {
    static_cast<void>(TEMP_FAILURE_RETRY(waitpid(child, nullptr, 0)));
  }
}

}  // namespace hecaton::services
