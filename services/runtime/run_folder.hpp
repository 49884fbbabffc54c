#pragma once
/// The folder in which one host's part of a cell keeps its checkpoints while it runs.

#include <chrono>
#include <filesystem>
#include <string>

#include "planner/model/source_file.hpp"

namespace hecaton::services {

/// Identifies a run on a machine: one host of a cell in a DDS domain.
struct RunName {
  std::string cell;
  int domain = 0;  ///< of DDS
  std::string host;
};

/// The file in the folder of the run from which a person learns the token of the view (services/view/token_file.hpp).
inline constexpr const char* kViewTokenFile = "view-token";

/// Where the folder of the run is, as chosen by the environment of this process. It need not exist.
[[nodiscard]] std::filesystem::path run_path(const RunName& run);

/// A text that is equal for two runs exactly when the checkpoints of one are valid for the other. It holds the
/// program's version (the checkpoints' format), this machine's boot (its clock) and the names and hashes of the cell's
/// files in `sources.read()` (robots and world). Throws std::runtime_error with a sentence when one of the files is
/// gone.
[[nodiscard]] std::string run_origin(const planner::SourceFiles& sources);

/// A run begins with an agent and ends when that agent is asked to end. After the agent was killed, its successor finds
/// the folder by the run's name and continues the run.
///
/// The folder is in /dev/shm, or in TMPDIR when that is set. Drivers write to a mapped file every period, and a page
/// that the kernel is writing to a disk would delay them.
class RunFolder {
 public:
  /// The next agent on this machine removes folders of other runs that were not used for this long.
  static constexpr std::chrono::hours kAbandoned{7 * 24};

  /// Creates or takes over the folder and locks it. Checkpoints of another `origin` (see run_origin) are removed; with
  /// `clean` all are. Throws std::runtime_error with a sentence when the folder cannot be used, for example because
  /// another process holds it.
  RunFolder(const RunName& run, const std::string& origin, bool clean = false);
  /// Removes the folder unless keep() was called.
  ~RunFolder();
  RunFolder(RunFolder&& other) noexcept;
  RunFolder& operator=(RunFolder&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// The folder has checkpoints of the same origin: the run continues.
  [[nodiscard]] bool resumed() const { return resumed_; }
  /// The folder had checkpoints of another origin, which were removed.
  [[nodiscard]] bool discarded() const { return discarded_; }

  /// The run has begun: from now on the folder outlives this process however it ends.
  void keep() { kept_ = true; }
  /// The run is over: the destructor removes the folder.
  void end() { kept_ = false; }
  /// Marks the folder as used. Call it at least once a day.
  void touch() const;

 private:
  void take(const RunName& run);
  void begin(const std::string& origin, bool clean);
  void remove_abandoned() const;
  void give_back();

  std::filesystem::path path_;
  int folder_ = -1;  ///< its descriptor, which holds the lock
  bool resumed_ = false;
  bool discarded_ = false;
  bool kept_ = false;
};

/// Removes what a run with a killed agent has left. Does nothing when there is no such folder or a process holds it.
void remove_run(const RunName& run);

}  // namespace hecaton::services
