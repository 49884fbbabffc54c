#pragma once
/// The hecaton-agent that `up` starts on this host: ends with us, and leaves nothing behind.

#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace hecaton::services::cli {

/// The program of that name in the folder of this one. Throws Failure (bad input) when it cannot be run.
[[nodiscard]] std::string sibling_program(const std::string& name);

class ChildAgent {
 public:
  /// Starts it with stdout and stderr appended to `log`, in a process group of its own, so that Ctrl-C on the terminal
  /// reaches us alone. It is told to end when the thread that started it ends. From now on this process adopts and
  /// reaps every orphan of its children. Throws Failure.
  ChildAgent(const std::vector<std::string>& arguments, const std::string& log);
  ~ChildAgent() { end(); }
  ChildAgent(const ChildAgent&) = delete;
  ChildAgent& operator=(const ChildAgent&) = delete;

  /// "exited with 3", "was ended by signal 9"; nothing while it runs.
  [[nodiscard]] std::optional<std::string> ended();
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Asks it to end and waits; afterwards it and all that it started are gone. False: some had to be killed.
  bool end();

 private:
  [[nodiscard]] bool wait_for_end(int milliseconds);

  pid_t pid_ = -1;
  int pidfd_ = -1;
  std::optional<int> status_;  ///< of waitpid
  bool over_ = false;
};

}  // namespace hecaton::services::cli
