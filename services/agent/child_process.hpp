#pragma once
/// A child process of the agent: started with a clean environment, ended with the agent, its exit noticed by a
/// descriptor.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <sys/types.h>

namespace hecaton::services {

struct ChildCommand {
  std::filesystem::path program;
  std::vector<std::string> arguments;  ///< without the program's name
  std::filesystem::path log;           ///< its stdout and stderr are appended here; empty: the parent's streams
  bool sends_heartbeats = false;       ///< it gets `--heartbeat-fd N`: a socket to which its loop sends bytes
  bool notifies_exit = false;          ///< it gets `--exit-fd N`: a pipe for its exit notifier (run_service.hpp)
  std::uint64_t most_data = 0;         ///< RLIMIT_DATA: heap, stacks and private mappings [byte]; 0: as the parent
};

struct ChildEnd {
  int exit_code = -1;     ///< −1 when a signal ended it
  int signal_number = 0;  ///< 0 when it returned
};

/// "… cannot be started: No such file or directory". `error`: errno.
[[nodiscard]] std::string start_failure(const std::filesystem::path& program, int error);

/// One thread: the child is killed when the thread that started it ends.
class ChildProcess {
 public:
  /// The child has a process group of its own, default signal handlers, an empty signal mask and at most the priority
  /// kStartup. Its stdin is empty; it inherits stdout, stderr and the descriptors of ChildCommand only. The constructor
  /// does not wait until the program is loaded, which a slow disk may delay: see poll_start(). Throws
  /// std::runtime_error with a sentence when no process can be created.
  explicit ChildProcess(const ChildCommand& command);
  /// Kills and reaps the child unless it was released.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Readable once the child has ended.
  [[nodiscard]] int fd() const { return pidfd_; }
  /// Readable once poll_announced_end() has a result; below 0: it had, or never will.
  [[nodiscard]] int exit_fd() const { return exit_; }
  /// Readable once poll_start() has a result; below 0: it had.
  [[nodiscard]] int start_fd() const { return start_; }
  /// Empty: the program is being loaded. 0: it runs. Otherwise errno of why it could not be started.
  [[nodiscard]] std::optional<int> poll_start();
  /// Does nothing after the end of the child was polled.
  void signal(int number) const;
  /// Resident memory [byte]; 0: it has ended.
  [[nodiscard]] std::uint64_t memory() const;
  /// Takes the heartbeats since the last call. Returns true when there were any.
  [[nodiscard]] bool take_heartbeats();
  /// How the child is about to end, returned once, as soon as the kernel has begun to end it. Its last thread and its
  /// memory may take much longer. Empty: unknown; poll_end() will tell.
  [[nodiscard]] std::optional<ChildEnd> poll_announced_end();
  /// How the child ended; empty while it runs.
  [[nodiscard]] std::optional<ChildEnd> poll_end();
  /// Call it after the end: the caller reaps the child by this pid.
  [[nodiscard]] pid_t release();

 private:
  void close_own();

  pid_t pid_ = -1;
  int pidfd_ = -1;
  int heartbeats_ = -1;  ///< own end of the socket
  int exit_ = -1;        ///< own end of the exit notifier's pipe
  int start_ = -1;       ///< own end of the pipe that exec closes
  int start_error_ = 0;
  std::optional<ChildEnd> end_;
};

/// Reaps ended children in a thread of low priority. The kernel may let reaping wait for a process that uses the
/// child's entry in /proc (release_task, shrink_dcache_parent). A reaper with real-time priority keeps that process
/// from running, so it waits for ever. At a higher niceness it waits for up to 1 s (measured on Linux 6.18).
class Reaper {
 public:
  /// Throws std::runtime_error with a sentence when no pipe can be created.
  Reaper();
  /// Waits until all given children are reaped.
  ~Reaper();
  Reaper(const Reaper&) = delete;
  Reaper& operator=(const Reaper&) = delete;

  /// `child` has ended or is about to. Never waits: it uses a pipe, because the thread could hold a lock.
  void take(pid_t child) const;

 private:
  void work() const;

  int begin_ = -1;
  int end_ = -1;
  std::thread thread_;
};

}  // namespace hecaton::services
