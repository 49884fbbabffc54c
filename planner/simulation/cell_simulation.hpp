#pragma once
/// A whole cell in virtual time, in one process. Planners, drivers' interpolation, Bullet world and contact monitor are
/// the live ones; clocks, processes and the network are simulated.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "planner/arm_planner/arm_planner.hpp"
#include "planner/cell.hpp"
#include "planner/simulation/arm_model.hpp"
#include "planner/simulation/network_model.hpp"
#include "planner/simulation/tasks.hpp"
#include "planner/simulation/velocity_reversals.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::planner {

enum class TaskOutcome : std::uint8_t { kReached, kBlocked, kTimedOut };

struct ArmOutcome {
  TaskOutcome outcome = TaskOutcome::kTimedOut;
  double time = 0.0;        ///< until the goal was reached, or until the end [s]
  int subspaces_drawn = 0;  ///< by boundary following
  int rollouts = 0;         ///< answers of the rollout search
  int routes = 0;           ///< routes begun
  int coupled_plans = 0;    ///< coupled plans proposed
  int relaxed_ticks = 0;    ///< ticks whose constraints had no solution, so that the arm braked
  int yielding_ticks = 0;   ///< ticks in which the arm gave way
  VelocityReversals reversals;
  std::string reason;  ///< why the goal was not reached: the end of a sentence; empty if it was
};

struct EpisodeOutcome {
  std::vector<ArmOutcome> arms;
  world::ContactReport contact_report;
  double duration = 0.0;            ///< virtual [s]
  std::uint64_t ticks = 0;          ///< of all arms
  std::uint64_t rollout_ticks = 0;  ///< simulated by all arms' rollouts
  bool ended_early = false;         ///< by EpisodeOptions::ended; the outcomes of the arms are unknown
};

/// Computing times [µs].
struct ComputingTimes {
  std::vector<double> tick_us;  ///< each tick, on the machine's clock
  double rollout_us = 0.0;      ///< all searches, processor time
  double run_us = 0.0;          ///< all periods, on the machine's clock; without drawing tasks and setting up
};

/// One period of one arm's planner. Valid during the callback.
struct PlannerPeriod {
  int arm = 0;
  const ArmPlannerOptions& options;  ///< of the planner
  const PeriodEvents& events;        ///< without the obstacles, which never change
  const PeriodInputs& inputs;
  const TickResult& result;
  const ArmPlanner& planner;  ///< after the period
  double time = 0.0;          ///< beginning of the period, virtual [s]
};

/// What all drivers and the world publish at one instant. Valid during the callback.
struct CellMoment {
  double time = 0.0;                 ///< virtual [s]
  std::span<const JointState> arms;  ///< measured, one per arm
  const world::ObstacleSnapshot& obstacles;
  const world::ContactReport& contacts;
};

/// Receives all that happens in an episode, and changes nothing in it.
class EpisodeLog {
 public:
  EpisodeLog() = default;
  virtual ~EpisodeLog() = default;
  EpisodeLog(const EpisodeLog&) = delete;
  EpisodeLog& operator=(const EpisodeLog&) = delete;

  /// Before the first period. `goals`: one per arm.
  virtual void begin(const CellConfiguration& goals) = 0;
  /// At the beginning of each period, and once at the end of the episode.
  virtual void publish(const CellMoment& moment) = 0;
  /// In each period of each planner, after publish(). With several threads, calls for different arms are concurrent.
  virtual void plan(const PlannerPeriod& period) = 0;
  /// After the last publish().
  virtual void end(const EpisodeOutcome& outcome) = 0;
};

struct EpisodeOptions {
  NetworkParameters network;
  std::vector<ServoParameters> servos = {};  ///< of each arm; empty: all are perfect
  double world_time = 0.0;                   ///< initial time of scripted motions [s]
  std::uint64_t seed = 1;
  int threads = 1;                  ///< share the arms of a period, if these are many; does not change the outcome
  ComputingTimes* times = nullptr;  ///< times are added here; null: not measured
  /// Called after every period with the virtual time [s], the measured configurations and the planners; may be empty.
  std::function<void(double, const CellConfiguration&, std::span<const ArmPlanner>)> observe;
  EpisodeLog* log = nullptr;  ///< null: none
  /// Called after every period; true ends the episode early. May be empty.
  std::function<bool()> ended;
};

/// Simulates one goal for each arm. All arms start at rest at `starts`. The episode ends when all have reached their
/// goals, at the cell's time limit, or when all open goals are blocked for 10 s. A goal that is open at the end is
/// kBlocked if its arm stands or has made no progress for long (planner/goal_progress.hpp), kTimedOut otherwise. The
/// same arguments give the same outcome to the last bit. `starts`, `goals`: one per arm.
[[nodiscard]] EpisodeOutcome simulate_episode(const Cell& cell, const CellConfiguration& starts,
                                              const CellConfiguration& goals, const EpisodeOptions& options);

}  // namespace hecaton::planner
