#pragma once
/// A cell that this process brought up on this host, from the first process to the last.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "services/cli/child_agent.hpp"
#include "services/client/connection.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services::cli {

/// Where the logs of a cell that `up` starts go.
class LogFolder {
 public:
  /// `wanted`, made if missing; empty: a new folder among the temporary ones. Throws Failure (bad input).
  LogFolder(const std::string& wanted, const std::string& cell);
  /// Removes a temporary folder unless it was asked to stay.
  ~LogFolder();
  LogFolder(const LogFolder&) = delete;
  LogFolder& operator=(const LogFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] bool temporary() const { return temporary_; }
  /// All went well: the logs tell nothing.
  void discard() { discard_ = temporary_; }

 private:
  std::string path_;
  bool temporary_ = false;
  bool discard_ = false;
};

/// Throws Failure (bad input) when nodes of any cell are alive in the domain.
void refuse_occupied_domain(int domain);

class RunningCell {
 public:
  struct Options {
    int domain = 42;
    std::string log_folder;  ///< of the agent's and the services' logs
  };
  /// Starts the agent. Throws Failure.
  RunningCell(const config::CellFile& file, const Options& options);

  /// Waits until the supervisor reports every node alive. `tell` gets a sentence when what is waited for changes.
  /// False: a signal came. Throws Failure: the agent ended, or time-out.
  [[nodiscard]] bool wait_until_up(double timeout, const std::function<void(const std::string&)>& tell);
  /// Asks the supervisor; false when it does not answer. Throws Failure when the agent has ended.
  bool look();
  [[nodiscard]] bool answered() const { return answered_; }  ///< at the last look
  /// As of the last look that was answered.
  [[nodiscard]] const msg::CellStatus& status() const { return status_; }
  [[nodiscard]] bool interrupted() const { return shutdown_.requested(); }
  [[nodiscard]] const config::CellFile& file() const { return file_; }
  [[nodiscard]] client::Connection& connection() { return *connection_; }
  [[nodiscard]] ChildAgent& agent() { return agent_; }

 private:
  /// This run is ours alone: what an agent that was killed would have left for another goes with us.
  struct Leftovers {
    ~Leftovers();
    const config::CellFile& file;
    int domain;
  };

  const config::CellFile& file_;
  std::string log_;
  std::shared_ptr<client::Connection> connection_;
  ShutdownSignal shutdown_;
  Leftovers leftovers_;  // after the agent
  ChildAgent agent_;
  bool answered_ = false;
  msg::CellStatus status_;
};

/// "planner/arm1 and world"; nothing when everything is there.
[[nodiscard]] std::optional<std::string> missing_parts(const msg::CellStatus& status);

}  // namespace hecaton::services::cli
