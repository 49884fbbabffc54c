#pragma once
/// Pictures of a simulated episode, step by step, into a folder.

#include <optional>
#include <string>
#include <vector>

#include "planner/simulation/batch.hpp"

namespace hecaton::services::cli {

/// Draws every arm that plans through C-space or down a potential field: every quarter of a second, and whenever it
/// searches its way anew.
class EpisodePlotter {
 public:
  /// Makes the folder if it is not there. Throws Failure when it cannot, or when no arm of the cell would be drawn.
  EpisodePlotter(std::string folder, const planner::Cell& cell);

  void draw(const planner::EpisodeMoment& moment);

  [[nodiscard]] int pictures() const { return pictures_; }
  /// A sentence; nothing: all pictures were written. (Nothing may be thrown in a simulation's threads.)
  [[nodiscard]] const std::optional<std::string>& failure() const { return failure_; }

 private:
  /// Of an arm.
  struct Past {
    std::vector<planner::JointVector> trace;
    int searches = -1;
  };

  void write(const planner::EpisodeMoment& moment, int arm);

  std::string folder_;
  std::optional<std::string> failure_;
  double due_ = 0.0;  ///< [s]
  std::vector<Past> past_;
  int pictures_ = 0;
};

}  // namespace hecaton::services::cli
