#pragma once
/// Records the planners of simulated episodes in the format of `hecaton record`, so that their ticks can be recomputed.

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"
#include "services/recorder/recording.hpp"
#include "services/tick_log/cell_changes.hpp"

namespace hecaton::services::cli {

/// Topic PlannerTick of all arms in all episodes. Times are virtual: an episode begins after the longest time of the
/// episodes before. Thread-safe.
class SimulationRecording {
 public:
  /// Creates the file. `changes`: of the cell that is simulated. Throws Failure when it cannot be written.
  SimulationRecording(const std::string& path, const config::CellFile& file, const CellChanges& changes);

  /// BatchOptions::record.
  [[nodiscard]] std::function<void(const planner::PlannerPeriod&)> record_episode(int episode,
                                                                                  const planner::Cell& cell);
  /// The file could not be written: nothing more is recorded.
  [[nodiscard]] bool failed() const { return failed_; }
  /// Closes the file. Throws Failure when it could not be written.
  void finish();
  [[nodiscard]] std::uint64_t ticks() const { return recording_.messages(); }

 private:
  class EpisodeTicks;
  void write(recorder::RecordedSample sample);
  void fail(const std::string& reason);

  std::mutex mutex_;
  recorder::Recording recording_;
  std::string failure_;
  std::atomic<bool> failed_ = false;
};

}  // namespace hecaton::services::cli
