#include "planner/simulation/batch.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "planner/simulation/clutter.hpp"
#include "planner/simulation/tasks.hpp"

namespace hecaton::planner {
namespace {

/// Scripted motions begin at a random time in this span [s].
constexpr double kScriptSpan = 60.0;
/// Starts that are drawn for a task until goals are found.
constexpr int kStarts = 5;
/// A batch fails if so many first episodes admit no task.
constexpr int kMostFailures = 50;
/// Random scenes tried for one episode in a cell with clutter.
constexpr int kScenes = 50;

struct EpisodeRecord {
  std::optional<std::string> failure;  ///< why no task could be drawn
  CellConfiguration goals;
  EpisodeOutcome outcome;
  ComputingTimes computing;
};

/// Starts, goals, and the world time at which they begin [s].
struct Task {
  CellConfiguration starts;
  CellConfiguration goals;
  double time = 0.0;
};

/// Draws the task of an episode that begins at world time `time` [s], or at another time if an obstacle is at the
/// starts then. Empty, with generator.shortage(), if there is none.
std::optional<Task> draw_task(TaskGenerator& generator, Random& random, double time) {
  std::optional<CellConfiguration> starts;
  std::optional<CellConfiguration> goals;
  // From some starts no goal is in conflict, such as those of arms with two joints.
  for (int draw = 0; draw < kStarts && !goals; ++draw) {
    starts = generator.draw_starts(random);
    if (!starts) return std::nullopt;
    goals = generator.draw_conflicting_goals(random, *starts);
  }
  if (!goals) return std::nullopt;
  if (!generator.clear_at(time, *starts)) {  // a pose of a sequence may be where an obstacle passes
    const auto other_time = generator.draw_time(random, kScriptSpan, *starts);
    if (!other_time) return std::nullopt;
    time = *other_time;
  }
  return Task{std::move(*starts), std::move(*goals), time};
}

/// `cell` has the scene of this episode.
EpisodeRecord run_in_scene(const Cell& cell, TaskGenerator& generator, Random random, const BatchOptions& options,
                           int episode, bool observed) {
  EpisodeRecord record;
  EpisodeOptions episode_options;
  episode_options.network = options.network;
  episode_options.servos = options.servos;
  episode_options.world_time = random.uniform(0.0, kScriptSpan);
  episode_options.seed = random.next();
  episode_options.threads = options.threads;
  episode_options.ended = options.ended;
  if (options.measure_ticks) episode_options.times = &record.computing;
  const auto task = draw_task(generator, random, episode_options.world_time);
  if (!task) {
    record.failure = generator.shortage();
    return record;
  }
  episode_options.world_time = task->time;
  if (observed && options.observe_first) {
    const double world_time = episode_options.world_time;
    episode_options.observe = [&, world_time](double time, const CellConfiguration& measured,
                                              std::span<const ArmPlanner> all) {
      options.observe_first({cell, task->goals, time, world_time + time, measured, all});
    };
  }
  std::unique_ptr<EpisodeLog> log;
  if (options.log != nullptr) log = options.log->begin(episode - options.first_episode, cell);
  episode_options.log = log.get();
  record.outcome = simulate_episode(cell, task->starts, task->goals, episode_options);
  record.goals = task->goals;
  return record;
}

/// The cell with the random obstacles of one scene.
Cell with_clutter(const Cell& cell, Random& random) {
  Cell cluttered = cell;
  for (world::Obstacle& obstacle : draw_clutter(cell.tasks.clutter, random)) {
    cluttered.scene.obstacles.push_back(std::move(obstacle));
  }
  return cluttered;
}

/// Draws scenes until one admits a task.
EpisodeRecord run_in_clutter(const Cell& cell, Random random, const BatchOptions& options, int episode, bool observed) {
  EpisodeRecord record;
  for (int scene = 0; scene < kScenes && (scene == 0 || record.failure); ++scene) {
    if (options.ended && options.ended()) record.outcome.ended_early = true;
    if (record.outcome.ended_early) break;
    const Cell cluttered = with_clutter(cell, random);
    TaskGenerator generator(cluttered);
    record = run_in_scene(cluttered, generator, Random(random.next()), options, episode, observed);
  }
  return record;
}

/// Each episode has its own random stream, so that its tasks depend on its number only.
Random random_of(std::uint64_t seed, int episode) {
  return Random(Random(seed).next() + static_cast<std::uint64_t>(episode) * 0xD134'2543'DE82'EF95ULL);
}

EpisodeRecord run_episode(const Cell& cell, TaskGenerator& generator, const BatchOptions& options, int episode,
                          bool observed) {
  const Random random = random_of(options.seed, episode);
  return cell.tasks.clutter.count > 0 ? run_in_clutter(cell, random, options, episode, observed)
                                      : run_in_scene(cell, generator, random, options, episode, observed);
}

void add(BatchReport& report, const EpisodeRecord& record, int episode, int tasks_left) {
  const EpisodeOutcome& outcome = record.outcome;
  const world::ContactReport& contacts = outcome.contact_report;
  report.contacts += contacts.contacts;
  if (contacts.has_smallest && (!report.has_smallest || contacts.smallest.distance < report.smallest.distance)) {
    report.smallest = contacts.smallest;
    report.has_smallest = true;
  }
  report.duration += outcome.duration;
  report.ticks += outcome.ticks;
  report.rollout_ticks += outcome.rollout_ticks;
  std::vector<double>& tick_us = report.computing.tick_us;
  tick_us.insert(tick_us.end(), record.computing.tick_us.begin(), record.computing.tick_us.end());
  report.computing.rollout_us += record.computing.rollout_us;
  report.computing.run_us += record.computing.run_us;
  for (int i = 0; i < std::min(tasks_left, static_cast<int>(outcome.arms.size())); ++i) {
    const ArmOutcome& arm = outcome.arms[i];
    ArmTally& tally = report.arms[i];
    ++report.tasks;
    ++tally.tasks;
    report.relaxed_ticks += static_cast<std::uint64_t>(arm.relaxed_ticks);
    report.yielding_ticks += static_cast<std::uint64_t>(arm.yielding_ticks);
    report.reversals += arm.reversals;
    report.rollouts += static_cast<std::uint64_t>(arm.rollouts);
    report.coupled_plans += static_cast<std::uint64_t>(arm.coupled_plans);
    report.routes += static_cast<std::uint64_t>(arm.routes);
    report.subspaces_drawn += static_cast<std::uint64_t>(arm.subspaces_drawn);
    switch (arm.outcome) {
      case TaskOutcome::kReached:
        ++report.reached;
        ++tally.reached;
        report.reach_times.push_back(arm.time);
        break;
      case TaskOutcome::kBlocked:
        ++report.blocked;
        ++tally.blocked;
        break;
      case TaskOutcome::kTimedOut:
        ++report.timed_out;
        ++tally.timed_out;
        break;
    }
    if (arm.outcome != TaskOutcome::kReached) {
      report.missed.push_back({episode, i, arm.outcome, record.goals[i], arm.reason});
    }
  }
}

/// The episodes of a batch and how far they are. Thread-safe.
class Episodes {
 public:
  Episodes(const Cell& cell, const BatchOptions& options)
      : cell_(cell),
        options_(options),
        arms_(static_cast<int>(cell.arms.size())),
        records_((options.tasks + arms_ - 1) / arms_) {}

  [[nodiscard]] int count() const { return static_cast<int>(records_.size()); }
  [[nodiscard]] bool ended() const { return options_.ended && options_.ended(); }

  /// Runs one. Returns false if no task could be drawn, or if the batch was ended meanwhile.
  bool run(int episode, TaskGenerator& generator, int threads, bool observed) {
    BatchOptions options = options_;
    options.threads = threads;
    EpisodeRecord record = run_episode(cell_, generator, options, options.first_episode + episode, observed);
    if (options.log != nullptr) options.log->end(episode);
    if (record.outcome.ended_early) return false;
    const bool drawn = !record.failure;
    const std::lock_guard lock(mutex_);
    records_[episode] = std::move(record);
    finished_ += std::min(arms_, options_.tasks - episode * arms_);
    if (options_.progress) options_.progress(finished_);
    return drawn;
  }

  [[nodiscard]] BatchReport report() const {
    BatchReport report;
    for (const PlannedArm& planned : cell_.arms) report.arms.push_back({.name = planned.arm.name});
    const std::string* failure = nullptr;
    int failed = 0;
    int complete = 0;
    for (int episode = 0; episode < count(); ++episode) {
      if (!records_[episode]) continue;
      ++complete;
      const EpisodeRecord& record = *records_[episode];
      if (!record.failure) {
        add(report, record, options_.first_episode + episode, options_.tasks - report.tasks);
        continue;
      }
      ++failed;
      if (failure == nullptr) failure = &*record.failure;
    }
    report.ended_early = complete < count() && ended();
    report.not_drawn = std::min(report.ended_early ? failed * arms_ : options_.tasks, options_.tasks - report.tasks);
    if (failure == nullptr) return report;
    report.failure =
        "cell '" + cell_.name + "': " +
        (report.ended_early ? std::to_string(report.not_drawn) + " tasks could not be drawn; for the first, "
         : report.tasks > 0 ? std::to_string(report.tasks) + " of " + std::to_string(options_.tasks) +
                                  " tasks could be drawn; for the first of the others, "
                            : "no task could be drawn in " + std::to_string(failed) +
                                  (failed == 1 ? " episode: " : " episodes: for the first, ")) +
        *failure;
    return report;
  }

 private:
  const Cell& cell_;
  const BatchOptions& options_;
  int arms_;
  std::vector<std::optional<EpisodeRecord>> records_;  ///< empty: not complete
  int finished_ = 0;                                   ///< tasks
  std::mutex mutex_;
};

}  // namespace

BatchReport simulate_tasks(const Cell& cell, const BatchOptions& options) {
  Episodes episodes(cell, options);
  // Until one task is drawn, run one episode at a time: in a cell that admits no task, each takes long to fail.
  TaskGenerator first(cell);
  int sequential = 0;
  bool drawn = false;
  while (!drawn && !episodes.ended() && sequential < std::min(episodes.count(), kMostFailures)) {
    drawn = episodes.run(sequential++, first, options.threads, true);
  }
  if (!drawn) return episodes.report();
  std::atomic<int> next = sequential;
  const int at_once = std::clamp(episodes.count() - 1, 1, options.threads);
  const auto work = [&] {
    if (next >= episodes.count()) return;
    TaskGenerator generator(cell);
    for (int episode = next++; episode < episodes.count() && !episodes.ended(); episode = next++) {
      episodes.run(episode, generator, options.threads / at_once, false);
    }
  };
  {
    std::vector<std::jthread> workers;
    for (int k = 1; k < at_once; ++k) workers.emplace_back(work);
    work();
  }
  return episodes.report();
}

std::optional<std::string> why_no_task(const Cell& cell, int episodes, std::uint64_t seed) {
  const bool clutter = cell.tasks.clutter.count > 0;
  TaskGenerator plain(cell);
  std::optional<std::string> failure;
  for (int episode = 0; episode < episodes; ++episode) {
    Random random = random_of(seed, episode);
    for (int scene = 0; scene < (clutter ? kScenes : 1); ++scene) {
      std::optional<TaskGenerator> in_clutter;
      if (clutter) in_clutter.emplace(with_clutter(cell, random));
      TaskGenerator& generator = in_clutter ? *in_clutter : plain;
      Random of_scene = clutter ? Random(random.next()) : random;
      const double time = of_scene.uniform(0.0, kScriptSpan);
      static_cast<void>(of_scene.next());  // the seed of the episode
      if (draw_task(generator, of_scene, time)) return std::nullopt;
      if (!failure) failure = generator.shortage();
    }
  }
  return failure;
}

}  // namespace hecaton::planner
