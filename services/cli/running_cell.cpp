#include "services/cli/running_cell.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/cli/cell_access.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/runtime/orders.hpp"
#include "services/runtime/run_folder.hpp"

namespace hecaton::services::cli {
namespace {

/// The agent kills its processes 2 s after it asked them to end.
constexpr int kAgentTimeout = 8000;   // [ms]
constexpr int kOrphanTimeout = 2000;  // [ms]

int open_pidfd(pid_t pid) {
  return static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
}

/// Parent of a process, from /proc; 0 when the process has ended.
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

/// Waits for the orphans of the agent, which this process has adopted. False: some had to be killed.
bool reap_orphans() {
  bool clean = true;
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(kOrphanTimeout);
  while (true) {
    const pid_t pid = waitpid(-1, nullptr, WNOHANG);
    if (pid < 0) return clean;  // no child is left
    if (pid > 0) continue;
    if (std::chrono::steady_clock::now() > until) {
      clean = false;
      for (const pid_t child : children()) kill(child, SIGKILL);
    }
    poll(nullptr, 0, 10);
  }
}

using namespace std::chrono_literals;

constexpr auto kDiscoveryLimit = 800ms;  // of nodes of a running cell on a busy machine; usually milliseconds
constexpr auto kReplyLimit = 500ms;

std::vector<std::string> agent_arguments(const config::CellFile& file, const RunningCell::Options& options) {
  std::vector<std::string> words{file.path,   "--clean",         "--domain", std::to_string(options.domain),
                                 "--log-dir", options.log_folder};
  if (options.view) words.emplace_back("--view");
  return words;
}

/// "planner/arm1 and world"; empty when the cell is complete.
std::optional<std::string> missing_parts(const msg::CellStatus& status) {
  std::vector<std::string> missing;
  for (const msg::NodeStatus& node : status.nodes()) {
    if (!node.alive()) missing.push_back(node.heartbeat().node());
  }
  for (const msg::ArmStatus& arm : status.arms()) {
    if (arm.state_age() < 0.0) missing.push_back("the state of " + arm.arm());
  }
  if (!status.has_contact_report()) missing.emplace_back("the contact monitor");
  if (status.arms().empty()) missing.emplace_back("arms");
  return missing.empty() ? std::nullopt : std::optional(listed(missing));
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
  const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
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
    // A signal may interrupt the wait. Without a descriptor (an old kernel) it polls every 10 ms.
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
  bool clean = true;
  if (!wait_for_end(0)) kill(pid_, SIGTERM);
  if (!wait_for_end(kAgentTimeout)) {
    clean = false;
    kill(-pid_, SIGKILL);
    static_cast<void>(wait_for_end(kAgentTimeout));
  }
  clean = reap_orphans() && clean;
  if (pidfd_ >= 0) close(pidfd_);
  return clean;
}

void become(const std::string& name, std::vector<std::string> arguments) {
  const std::string program = sibling_program(name);
  // "hecaton view" as its name: its complaints begin as those of `hecaton`.
  std::string called = name;
  std::replace(called.begin(), called.end(), '-', ' ');
  std::vector<char*> argv{called.data()};
  for (std::string& word : arguments) argv.push_back(word.data());
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  throw Failure(ExitCode::kBadInput, "program '" + program + "' cannot be run: " + std::strerror(errno));
}

LogFolder::LogFolder(const std::string& wanted, const std::string& cell) : path_(wanted), temporary_(wanted.empty()) {
  std::error_code error;
  if (!temporary_) {
    std::filesystem::create_directories(path_, error);
    path_ = std::filesystem::absolute(path_);
    if (error) throw Failure(ExitCode::kBadInput, "log folder '" + path_ + "' cannot be created: " + error.message());
    return;
  }
  const char* chosen = std::getenv("TMPDIR");
  const std::filesystem::path parent = chosen == nullptr || *chosen == '\0' ? "/tmp" : chosen;
  std::string name = parent / ("hecaton-" + cell + "-XXXXXX");
  if (mkdtemp(name.data()) == nullptr) {
    throw Failure(ExitCode::kBadInput, "a log folder cannot be created in " + parent.string() + ": " +
                                           std::strerror(errno) + "; name another place by --log-dir or TMPDIR");
  }
  path_ = name;
}

LogFolder::~LogFolder() {
  std::error_code ignored;
  if (discard_) std::filesystem::remove_all(path_, ignored);
}

void refuse_occupied_domain(int domain) {
  const auto probe = client::Connection::make(client::join({std::nullopt, domain}));
  bus::Reader<msg::Heartbeat> heartbeats(probe->participant(), &probe->mailbox());
  if (!probe->wait_until([&] { return !heartbeats.take().empty(); }, kDiscoveryLimit)) return;
  const auto status = probe->poll_status(kReplyLimit);
  const std::string name = status ? " '" + status->cell() + "'" : "";
  throw Failure(ExitCode::kBadInput, "another cell" + name + " runs in DDS domain " + std::to_string(domain) +
                                         "; stop it, or choose another domain with --domain");
}

RunningCell::RunningCell(const config::CellFile& file, const Options& options)
    : file_(file),
      log_(options.log_folder + "/agent.log"),
      connection_(client::Connection::make(client::join(file, options.domain))),
      cleanup_{file, options.domain},
      agent_(agent_arguments(file, options), log_) {
  shutdown_.wake(&connection_->mailbox());
}

RunningCell::RunFolderCleanup::~RunFolderCleanup() {
  for (const config::Host& host : file.hosts) remove_run({file.cell.name, domain, host.name});
}

bool RunningCell::poll() {
  if (const auto ended = agent_.ended()) {
    throw Failure(ExitCode::kNegative, "the agent of the cell " + *ended + "; see its log " + log_);
  }
  const auto newest = connection_->poll_status(kReplyLimit);
  answered_ = newest.has_value();
  if (answered_) status_ = *newest;
  return answered_;
}

bool RunningCell::wait_until_up(double timeout, const std::function<void(const std::string&)>& tell) {
  const auto until = client::deadline_of(Seconds(timeout));
  std::string reported;
  while (!interrupted()) {
    const bool answered = poll();
    const auto missing = answered ? missing_parts(status_) : "the supervisor";
    if (!missing && status_.mode().mode() == msg::Mode::MODE_RUN) return true;
    const std::string waits = missing ? *missing : "mode run of the cell: " + causes_text(status_.mode());
    if (waits != reported) tell("waiting for " + waits);
    reported = waits;
    if (client::Clock::now() > until) {
      throw Failure(ExitCode::kTimeOut, "the cell is not up after " + duration_text(timeout) + ": waiting for " +
                                            waits + "; see the logs beside " + log_);
    }
    if (answered) static_cast<void>(connection_->wait_until([this] { return interrupted(); }, 50ms));
  }
  return false;
}

}  // namespace hecaton::services::cli
