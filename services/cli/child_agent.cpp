#include "services/cli/child_agent.hpp"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/command_line/failure.hpp"

namespace hecaton::services::cli {
namespace {

/// The agent itself kills what does not end within 2 s.
constexpr int kPatience = 8000;        // [ms]
constexpr int kOrphanPatience = 2000;  // [ms]

int open_pidfd(pid_t pid) {
  return static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
}

/// Parent of a process, from /proc; 0 when it is gone.
pid_t parent_of(const std::string& pid) {
  std::ifstream file("/proc/" + pid + "/stat");
  std::string line;
  if (!std::getline(file, line)) return 0;
  // "pid (name, which may hold anything) state ppid …"
  const std::size_t name_end = line.rfind(')');
  if (name_end == std::string::npos || name_end + 4 >= line.size()) return 0;
  return static_cast<pid_t>(std::strtol(line.c_str() + name_end + 4, nullptr, 10));
}

std::vector<pid_t> children() {
  std::vector<pid_t> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (parent_of(name) == getpid()) found.push_back(static_cast<pid_t>(std::stol(name)));
  }
  return found;
}

/// Orphans of the agent became our children. False: some had to be killed.
bool reap_orphans() {
  bool gentle = true;
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(kOrphanPatience);
  while (true) {
    const pid_t pid = waitpid(-1, nullptr, WNOHANG);
    if (pid < 0) return gentle;  // no child is left
    if (pid > 0) continue;
    if (std::chrono::steady_clock::now() > until) {
      gentle = false;
      for (const pid_t child : children()) kill(child, SIGKILL);
    }
    poll(nullptr, 0, 10);
  }
}

}  // namespace

std::string sibling_program(const std::string& name) {
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
  if (access(program.c_str(), X_OK) != 0) {
    throw Failure(ExitCode::kBadInput, "program '" + program.string() + "' cannot be run: " + std::strerror(errno));
  }
  return program;
}

ChildAgent::ChildAgent(const std::vector<std::string>& arguments, const std::string& log) {
  std::string program = sibling_program("hecaton-agent");
  std::vector<std::string> words = arguments;
  words.insert(words.begin(), program);
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (output < 0)
    throw Failure(ExitCode::kBadInput, "log file '" + log + "' cannot be written: " + std::strerror(errno));
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  prctl(PR_SET_CHILD_SUBREAPER, 1);

  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) {
    // Between fork and exec of a process with threads only async-signal-safe calls are allowed.
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);
    signal(SIGPIPE, SIG_DFL);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    dup2(nothing, STDIN_FILENO);
    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
    syscall(SYS_close_range, 3U, ~0U, 4U /* CLOSE_RANGE_CLOEXEC */);
    execv(program.c_str(), argv.data());
    _exit(127);
  }
  close(output);
  close(nothing);
  if (pid_ < 0) throw Failure(ExitCode::kBadInput, std::string("no process can be started: ") + std::strerror(errno));
  setpgid(pid_, pid_);
  pidfd_ = open_pidfd(pid_);
}

bool ChildAgent::wait_for_end(int milliseconds) {
  if (status_) return true;
  pollfd descriptor{pidfd_, POLLIN, 0};
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(milliseconds);
  while (true) {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == pid_) {
      status_ = status;
      return true;
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now()).count();
    if (left <= 0) return false;
    // A signal may interrupt the wait; without a descriptor (an old kernel) look again soon.
    poll(&descriptor, pidfd_ >= 0 ? 1 : 0, static_cast<int>(pidfd_ >= 0 ? left : 10));
  }
}

std::optional<std::string> ChildAgent::ended() {
  if (!wait_for_end(0)) return std::nullopt;
  if (WIFSIGNALED(*status_)) return "was ended by signal " + std::to_string(WTERMSIG(*status_));
  return "exited with " + std::to_string(WEXITSTATUS(*status_));
}

bool ChildAgent::end() {
  if (over_) return true;
  over_ = true;
  bool gentle = true;
  if (!wait_for_end(0)) kill(pid_, SIGTERM);
  if (!wait_for_end(kPatience)) {
    gentle = false;
    kill(-pid_, SIGKILL);
    static_cast<void>(wait_for_end(kPatience));
  }
  gentle = reap_orphans() && gentle;
  if (pidfd_ >= 0) close(pidfd_);
  return gentle;
}

}  // namespace hecaton::services::cli
