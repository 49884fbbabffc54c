#pragma once
/// The messages that the nodes of a live cell would publish in an episode of the simulation.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "planner/simulation/cell_simulation.hpp"
#include "services/config/cell_file.hpp"
#include "services/recorder/recording.hpp"

namespace hecaton::services {

/// Makes the samples of one episode. Rates are those of a live cell; heartbeats come twice in a host lease. Stamps and
/// log times are virtual, from 0 at the begin of the episode, and terms are the number of the episode, from 1. Calls
/// follow the rules of EpisodeLog.
class EpisodeMessages {
 public:
  using Samples = std::vector<recorder::RecordedSample>;

  /// `file` and `cell` must outlive it. `cell`: that of the episode. `episode`: from 0.
  EpisodeMessages(const config::CellFile& file, const planner::Cell& cell, int episode);
  ~EpisodeMessages();
  EpisodeMessages(const EpisodeMessages&) = delete;
  EpisodeMessages& operator=(const EpisodeMessages&) = delete;

  void begin(const planner::CellConfiguration& goals);
  void publish(const planner::CellMoment& moment);
  void plan(const planner::PlannerPeriod& period);
  void end(const planner::EpisodeOutcome& outcome);

  /// The samples since the last call, in an order that does not depend on threads. A sample without bytes breaks a rule
  /// of the wire.
  [[nodiscard]] Samples take();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
