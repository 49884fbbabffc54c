#pragma once
/// A cell that `up` runs on this host: its logs, its agent, and its status.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "services/client/connection.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services::cli {

/// Path of a program in the folder of this one. Throws Failure (bad input) when it cannot be run.
[[nodiscard]] std::string sibling_program(const std::string& name);

/// Replaces this process by that program with these arguments. Throws Failure (bad input) when it cannot be run.
[[noreturn]] void become(const std::string& name, std::vector<std::string> arguments);

/// Folder for the logs of a cell.
class LogFolder {
 public:
  /// `wanted` is made if it is missing; empty: a new temporary folder. Throws Failure (bad input).
  LogFolder(const std::string& wanted, const std::string& cell);
  /// Removes a temporary folder after discard().
  ~LogFolder();
  LogFolder(const LogFolder&) = delete;
  LogFolder& operator=(const LogFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// The run had no errors: a temporary folder is not needed.
  void discard() { discard_ = temporary_; }

 private:
  std::string path_;
  bool temporary_ = false;
  bool discard_ = false;
};

/// Throws Failure (bad input) when any node publishes heartbeats in the domain.
void refuse_occupied_domain(int domain);

/// The hecaton-agent as a child process. It ends with this process and leaves no process behind.
class ChildAgent {
 public:
  /// Starts it with stdout and stderr appended to `log`. It has a process group of its own, so that Ctrl-C on the
  /// terminal reaches this process alone, and gets SIGTERM when the thread that started it ends. From now on this
  /// process adopts and reaps all orphans of its children. Throws Failure.
  ChildAgent(const std::vector<std::string>& arguments, const std::string& log);
  ~ChildAgent() { end(); }
  ChildAgent(const ChildAgent&) = delete;
  ChildAgent& operator=(const ChildAgent&) = delete;

  /// "exited with 3", "was ended by signal 9"; empty while it runs.
  [[nodiscard]] std::optional<std::string> ended();
  /// Sends SIGTERM and waits; afterwards the agent and all processes that it started have ended. False: some processes
  /// did not end in time and were killed.
  bool end();

 private:
  [[nodiscard]] bool wait_for_end(int milliseconds);

  pid_t pid_ = -1;
  int pidfd_ = -1;
  std::optional<int> status_;  ///< of waitpid
  bool over_ = false;
};

/// A cell from the start of its agent to the end of its last process. For one thread.
class RunningCell {
 public:
  struct Options {
    int domain = 42;
    std::string log_folder;  ///< of the agent's and the services' logs
    bool view = false;       ///< starts the view also if the cell file has no key view
  };
  /// Starts the agent. `file` must outlive the object. Throws Failure.
  RunningCell(const config::CellFile& file, const Options& options);

  /// Waits until the supervisor reports every node alive and mode run. `tell` gets a sentence when the missing parts
  /// change. False: a signal came. Throws Failure when the agent has ended or after `timeout` [s].
  [[nodiscard]] bool wait_until_up(double timeout, const std::function<void(const std::string&)>& tell);
  /// Asks the supervisor for its status; false when it does not answer. Throws Failure when the agent has ended.
  bool poll();
  [[nodiscard]] bool answered() const { return answered_; }  ///< the last poll
  /// Of the last poll that was answered.
  [[nodiscard]] const msg::CellStatus& status() const { return status_; }
  [[nodiscard]] bool interrupted() const { return shutdown_.requested(); }
  /// That interrupted the run; 0: none.
  [[nodiscard]] int signal() const { return shutdown_.signal(); }
  [[nodiscard]] const config::CellFile& file() const { return file_; }
  [[nodiscard]] client::Connection& connection() { return *connection_; }
  [[nodiscard]] ChildAgent& agent() { return agent_; }

 private:
  /// Removes the run folders that a killed agent would leave for a later run.
  struct RunFolderCleanup {
    ~RunFolderCleanup();
    const config::CellFile& file;
    int domain;
  };

  const config::CellFile& file_;
  std::string log_;
  std::shared_ptr<client::Connection> connection_;
  ShutdownSignal shutdown_{ShutdownSignal::Second::kEndsProcess};
  RunFolderCleanup cleanup_;  // runs after the agent's destructor
  ChildAgent agent_;
  bool answered_ = false;
  msg::CellStatus status_;
};

}  // namespace hecaton::services::cli
