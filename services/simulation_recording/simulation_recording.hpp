#pragma once
/// Records simulated episodes in the format of `hecaton record`, for the same readers.

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"
#include "services/recorder/recording.hpp"
#include "services/tick_log/cell_changes.hpp"

namespace hecaton::services {

/// The messages of all episodes, one episode after the other, in virtual time from 0. An episode begins one control
/// period after the end of the episode before. An episode that runs beside an earlier one waits in memory, so that the
/// file does not depend on the number of threads. Thread-safe.
class SimulationRecording : public planner::BatchLog {
 public:
  /// Creates the file. `file` must outlive the recording. `changes`: of the cell that is simulated. Throws
  /// RecordingError when it cannot be written.
  SimulationRecording(const std::string& path, const config::CellFile& file, const CellChanges& changes);
  ~SimulationRecording() override;

  std::unique_ptr<planner::EpisodeLog> begin(int episode, const planner::Cell& cell) override;
  void end(int episode) override;

  /// The file could not be written: nothing more is recorded.
  [[nodiscard]] bool failed() const { return failed_; }
  /// Closes the file. Throws RecordingError when it could not be written.
  void finish();
  [[nodiscard]] std::uint64_t messages() const { return recording_.messages(); }
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }  ///< of planners

 private:
  class Episode;
  using Samples = std::vector<recorder::RecordedSample>;
  /// An episode that is not written yet.
  struct Waiting {
    Samples samples;
    bool ended = false;
  };

  /// Log times are those of the episode.
  void take(int episode, Samples samples);
  void write_all(Samples samples);
  void write(recorder::RecordedSample sample);
  void write_report();
  void fail(const std::string& reason);

  const config::CellFile& file_;
  std::mutex mutex_;
  recorder::Recording recording_;
  std::map<int, Waiting> waiting_;
  int written_ = 0;          ///< the episode whose samples are written at once
  bool begun_ = false;       ///< it has samples
  std::uint64_t began_ = 0;  ///< it [ns]
  std::uint64_t last_ = 0;   ///< log time [ns]
  std::uint64_t ticks_ = 0;
  std::map<bus::EndpointId, std::uint64_t> numbers_;  ///< of the last sample of each writer
  std::map<std::size_t, std::uint64_t> counts_;       ///< samples, by topic
  std::string failure_;
  std::atomic<bool> failed_ = false;
};

}  // namespace hecaton::services
