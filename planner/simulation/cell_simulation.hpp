#pragma once
/// A whole cell in virtual time, in one process: the planners' own ticks, the drivers' own servo, the world's own
/// Bullet and contact monitor; only clocks, processes and the network are simulated.

#include <functional>
#include <span>
#include <vector>

#include "planner/arm_planner/arm_planner.hpp"
#include "planner/cell.hpp"
#include "planner/simulation/arm_model.hpp"
#include "planner/simulation/velocity_reversals.hpp"
#include "planner/simulation/network_model.hpp"
#include "planner/simulation/tasks.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::planner {

enum class TaskOutcome : std::uint8_t { kReached, kBlocked, kTimedOut };

struct ArmOutcome {
  TaskOutcome outcome = TaskOutcome::kTimedOut;
  double time = 0.0;       ///< until reached, or the time limit [s]
  int subspaces_drawn = 0;         ///< subspaces drawn
  int rollouts = 0;        ///< answers of the rollout search
  int routes = 0;          ///< routes begun
  int coupled_plans = 0;   ///< coupled plans proposed
  int relaxed_ticks = 0;   ///< ticks that braked because the rows asked for more
  int yielding_ticks = 0;  ///< ticks in which it made room for another arm
  VelocityReversals reversals;
};

struct EpisodeOutcome {
  std::vector<ArmOutcome> arms;
  world::ContactReport contact_report;
  double duration = 0.0;            ///< virtual [s]
  std::uint64_t ticks = 0;          ///< of all arms
  std::uint64_t rollout_ticks = 0;  ///< that all arms' rollouts played
};

/// What was spent [µs].
struct ClockedTimes {
  std::vector<double> tick_us;  ///< on each tick, on the machine's clock
  double rollout_us = 0.0;      ///< on all rollouts together, of the processor
  double run_us = 0.0;          ///< on all periods, on the machine's clock: without drawing tasks and setting up
};

/// One period of one arm's planner. Valid during the call.
struct PlannerPeriod {
  int arm = 0;
  const ArmPlannerOptions& options;  ///< of the planner
  const PeriodEvents& events;        ///< without the obstacles: these never change
  const PeriodInputs& inputs;
  const TickResult& result;
};

struct EpisodeOptions {
  NetworkParameters network;
  double world_time = 0.0;  ///< at which instant of their scripts the obstacles begin [s]
  std::uint64_t seed = 1;
  int threads = 1;  ///< that share the arms of a period, if these are many; the outcome does not depend on it
  ClockedTimes* times = nullptr;  ///< to be added to; may be null
  /// Called after every period with the virtual time, the measured configurations and the planners; may be empty.
  std::function<void(double, const CellConfiguration&, std::span<const ArmPlanner>)> observe;
  /// Called in every period of every arm's planner; may be empty. With several threads: by several at once.
  std::function<void(const PlannerPeriod&)> record;
};

/// All arms start at rest at `starts` and get their goals at once; ends when all have reached them, at the cell's time
/// limit, or when none moves any more although goals are open. Whose goal is open then: kBlocked when it does not move
/// or has not come nearer for long (planner/progress_monitor.hpp), otherwise kTimedOut. Deterministic: same cell, starts, goals
/// and options, same outcome to the last bit.
[[nodiscard]] EpisodeOutcome simulate_episode(const Cell& cell, const CellConfiguration& starts,
                                              const CellConfiguration& goals, const EpisodeOptions& options);

}  // namespace hecaton::planner
