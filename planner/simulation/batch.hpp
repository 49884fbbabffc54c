#pragma once
/// Many independent episodes of one cell, and their statistics: what `hecaton simulate` reports.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planner/simulation/cell_simulation.hpp"

namespace hecaton::planner {

/// One period of an episode. Valid during the callback.
struct EpisodeMoment {
  const Cell& cell;  ///< with the episode's own scene
  const CellConfiguration& goals;
  double time;        ///< virtual [s]
  double world_time;  ///< of scripted motions [s]
  const CellConfiguration& measured;
  std::span<const ArmPlanner> planners;
};

/// Makes the logs of a batch's episodes. With several threads, calls are concurrent.
class BatchLog {
 public:
  BatchLog() = default;
  virtual ~BatchLog() = default;
  BatchLog(const BatchLog&) = delete;
  BatchLog& operator=(const BatchLog&) = delete;

  /// `episode`: from 0, of this batch.
  /// Before an episode whose task could be drawn. `cell` has the episode's own scene, and lives as long as the episode.
  virtual std::unique_ptr<EpisodeLog> begin(int episode, const Cell& cell) = 0;
  /// The episode has ended, or had no task. Called for each episode that was tried.
  virtual void end(int episode) = 0;
};

struct BatchOptions {
  int tasks = 100;  ///< goals of single arms in total; an episode has one for each arm
  std::uint64_t seed = 1;
  int first_episode = 0;  ///< of those with this seed; an episode depends on its number and the seed alone
  int threads = 1;        ///< run episodes in parallel; surplus threads share the arms of an episode
  NetworkParameters network;
  std::vector<ServoParameters> servos = {};  ///< of each arm; empty: all are perfect
  bool measure_ticks = false;                ///< measures computing times
  std::function<void(const EpisodeMoment&)>
      observe_first;        ///< called in every period of the first episode; may be empty
  BatchLog* log = nullptr;  ///< null: none
  /// Called with the number of finished tasks after each episode; calls are serialized. May be empty.
  std::function<void(int)> progress;
  /// Called in every period of each episode, by its thread; true ends the batch: the report then holds the episodes
  /// that were complete. May be empty.
  std::function<bool()> ended;
};

/// A task that was not reached.
struct MissedTask {
  int episode = 0;  ///< from 0
  int arm = 0;      ///< index
  TaskOutcome outcome = TaskOutcome::kBlocked;
  JointVector goal;
  std::string reason;  ///< the end of a sentence
};

struct ArmTally {
  std::string name;
  int tasks = 0;
  int reached = 0;
  int blocked = 0;
  int timed_out = 0;
};

/// Sums over all episodes and arms.
struct BatchReport {
  int tasks = 0;
  int reached = 0;
  int blocked = 0;
  int timed_out = 0;
  std::uint64_t contacts = 0;
  bool has_smallest = false;
  world::Separation smallest;  ///< valid if has_smallest
  double duration = 0.0;       ///< virtual [s]
  std::uint64_t ticks = 0;
  std::uint64_t rollouts = 0;       ///< answers of the rollout search
  std::uint64_t routes = 0;         ///< routes begun
  std::uint64_t coupled_plans = 0;  ///< coupled plans proposed
  std::uint64_t rollout_ticks = 0;  ///< ticks of single arms simulated by rollouts
  std::uint64_t relaxed_ticks = 0;
  std::uint64_t subspaces_drawn = 0;
  std::uint64_t yielding_ticks = 0;
  VelocityReversals reversals;
  std::vector<double> reach_times;  ///< of the goals reached, in task order [s]
  ComputingTimes computing;         ///< if measured
  std::vector<ArmTally> arms;
  std::vector<MissedTask> missed;      ///< in task order
  int not_drawn = 0;                   ///< tasks without free starts and goals
  bool ended_early = false;            ///< by BatchOptions::ended
  std::optional<std::string> failure;  ///< a sentence if some tasks could not be drawn
};

/// Simulates random tasks of a cell. Starts and goals depend on the seed and the cell only, so that methods can be
/// compared on the same tasks. The report does not depend on the number of threads.
[[nodiscard]] BatchReport simulate_tasks(const Cell& cell, const BatchOptions& options);

/// Why none of the first `episodes` of a batch with this seed can be drawn: the end of a sentence. Nothing as soon as
/// one can. Takes seconds for a cell that admits no task.
[[nodiscard]] std::optional<std::string> why_no_task(const Cell& cell, int episodes, std::uint64_t seed = 1);

}  // namespace hecaton::planner
