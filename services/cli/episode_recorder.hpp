#pragma once
/// Records a simulated episode for programs that draw it.

#include <fstream>
#include <string>

#include "planner/simulation/batch.hpp"

namespace hecaton::services::cli {

/// Writes an episode as lines of JSON, one for each 50 ms of virtual time. A line has `time` [s], and for each arm and
/// each obstacle its shapes in the world frame W [m]. An arm also has the origin of its tool frame, and the goal of
/// this point. A carried obstacle is where its arm has it; a dynamic one is where it started.
class EpisodeRecorder {
 public:
  /// Throws Failure when the file cannot be written.
  explicit EpisodeRecorder(std::string path);

  /// Never throws: it runs in a thread of the simulation.
  void record(const planner::EpisodeMoment& moment);
  /// Throws Failure when a line could not be written.
  void finish();

 private:
  std::string path_;
  std::ofstream file_;
  double due_ = 0.0;  ///< time of the next line [s]
};

}  // namespace hecaton::services::cli
