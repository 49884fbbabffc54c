#pragma once
/// Many independent episodes of one cell: the numbers that `hecaton simulate` reports.

#include <cstdint>
#include <string>
#include <vector>

#include "planner/simulation/cell_simulation.hpp"

namespace hecaton::planner {

/// One period of an episode.
struct EpisodeMoment {
  const Cell& cell;  ///< with the episode's own scene
  const CellConfiguration& goals;
  double time;  ///< virtual [s]
  const CellConfiguration& measured;
  std::span<const ArmPlanner> planners;
};

struct BatchOptions {
  int tasks = 100;  ///< goals for single arms, in total; an episode gives one to every arm
  std::uint64_t seed = 1;
  int threads = 1;  ///< episodes at the same time; what is left over shares the arms of one
  NetworkParameters network;
  bool measure_ticks = false;                               ///< fills clocked with the machine's clock
  std::function<void(const EpisodeMoment&)> observe_first;  ///< called in every period of the first episode, or empty
};

struct ArmTally {
  std::string name;
  int tasks = 0;
  int reached = 0;
  int blocked = 0;
  int timed_out = 0;
};

struct BatchReport {
  int tasks = 0;
  int reached = 0;
  int blocked = 0;
  int timed_out = 0;
  std::uint64_t contacts = 0;  ///< the contact monitor's
  bool has_smallest = false;
  world::Separation smallest;  ///< the contact monitor's, over all episodes
  double duration = 0.0;       ///< virtual [s]
  std::uint64_t ticks = 0;
  std::uint64_t rollouts = 0;       ///< answers of the rollout search
  std::uint64_t routes = 0;         ///< begun
  std::uint64_t coupled_plans = 0;  ///< coupled plans proposed
  std::uint64_t rollout_ticks = 0;  ///< played for them, of single arms
  std::uint64_t relaxed_ticks = 0;
  std::uint64_t subspaces_drawn = 0;
  std::uint64_t yielding_ticks = 0;
  VelocityReversals reversals;            ///< of all arms
  std::vector<double> times;  ///< of the tasks that were reached, in task order [s]
  ClockedTimes clocked;       ///< when measured
  std::vector<ArmTally> arms;
  std::string failure;  ///< one sentence when not all tasks could be drawn; `tasks` of them were
};

/// Starts and goals depend on the seed and the cell alone, never on how the arms move: methods can be compared on the
/// same tasks. The report is the same for any number of threads.
[[nodiscard]] BatchReport simulate_tasks(const Cell& cell, const BatchOptions& options);

}  // namespace hecaton::planner
