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
};

struct ChildEnd {
  int exit_code = -1;     ///< −1 when a signal ended it
  int signal_number = 0;  ///< 0 when it returned
};

/// "… cannot be started: No such file or directory".
[[nodiscard]] std::string start_failure(const std::filesystem::path& program, int error);

class ChildProcess {
 public:
  /// The child has a process group of its own, default signal handlers, an empty signal mask, no descriptors of ours
  /// but stdout and stderr (stdin reads nothing) and the socket for signs of life, and is killed when the thread that
  /// started it ends. Does not wait for its program to be read, from a disk that may be slow: see poll_start(). Throws
  /// std::runtime_error with a sentence when there can be no process.
  explicit ChildProcess(const ChildCommand& command);
  /// Kills and reaps a child that still runs.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Readable once the child has ended.
  [[nodiscard]] int fd() const { return pidfd_; }
  /// Readable once poll_start() knows; below 0: it does.
  [[nodiscard]] int start_fd() const { return start_; }
  /// Empty: not known yet; otherwise errno of why the child did not become its program, 0: it did.
  [[nodiscard]] std::optional<int> poll_start();
  void signal(int number) const;
  /// Whether it has told since the last call that it lives.
  [[nodiscard]] bool told_alive();
  /// How it ended; empty while it runs. Reaps it.
  [[nodiscard]] std::optional<ChildEnd> poll_end();

 private:
  void close_own();

  pid_t pid_ = -1;
  int pidfd_ = -1;
  int alive_ = -1;  ///< our end of the socket
  int start_ = -1;  ///< our end of the pipe that exec closes
  int start_error_ = 0;
  std::optional<ChildEnd> end_;
};

}  // namespace hecaton::services
