#pragma once
/// A process of ours: started clean, ended with us, noticed by a descriptor when it ends.

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace hecaton::services {

struct ChildCommand {
  std::filesystem::path program;
  std::vector<std::string> arguments;  ///< without the program's own name
  std::filesystem::path log;           ///< its stdout and stderr are appended here; empty: ours
  bool tells_alive = false;            ///< it gets `--alive-fd N`, a socket on which it tells that it lives
  bool tells_end = false;  ///< and `--life-fd N`, a pipe by whose end it does so (services/runtime/life_line.hpp)
};

struct ChildEnd {
  int exit_code = -1;     ///< −1 when a signal ended it
  int signal_number = 0;  ///< 0 when it returned
};

/// "… cannot be started: No such file or directory".
[[nodiscard]] std::string start_failure(const std::filesystem::path& program, int error);

class ChildProcess {
 public:
  /// The child has a process group of its own, default signal handlers, an empty signal mask, no more than a start's
  /// priority, no descriptors of ours but stdout and stderr (stdin reads nothing) and what it tells of its life by, and
  /// is killed when the thread that started it ends. Does not wait for its program to be read, from a disk that may be
  /// slow: see poll_start(). Throws std::runtime_error with a sentence when there can be no process.
  explicit ChildProcess(const ChildCommand& command);
  /// Kills and reaps a child that nobody let go.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Readable once the child has ended.
  [[nodiscard]] int fd() const { return pidfd_; }
  /// Readable once poll_doom() knows; below 0: it does, or never will.
  [[nodiscard]] int life_fd() const { return life_; }
  /// Readable once poll_start() knows; below 0: it does.
  [[nodiscard]] int start_fd() const { return start_; }
  /// Empty: not known yet; otherwise errno of why the child did not become its program, 0: it did.
  [[nodiscard]] std::optional<int> poll_start();
  void signal(int number) const;
  /// Whether it has told since the last call that it lives.
  [[nodiscard]] bool told_alive();
  /// How it is about to end; told once, from the instant in which the kernel has begun to end it. Its last thread and
  /// its memory may take much longer than that. Empty: it is not known to be; poll_end() will tell.
  [[nodiscard]] std::optional<ChildEnd> poll_doom();
  /// How it ended; empty while it runs.
  [[nodiscard]] std::optional<ChildEnd> poll_end();
  /// Once it has ended: the caller reaps it, by this number.
  [[nodiscard]] pid_t let_go();

 private:
  void close_own();

  pid_t pid_ = -1;
  int pidfd_ = -1;
  int alive_ = -1;  ///< our end of the socket
  int life_ = -1;   ///< our end of the pipe that its end closes
  int start_ = -1;  ///< our end of the pipe that exec closes
  int start_error_ = 0;
  std::optional<ChildEnd> end_;
};

}  // namespace hecaton::services
