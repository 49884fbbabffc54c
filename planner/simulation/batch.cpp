#include "planner/simulation/batch.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

#include "planner/simulation/tasks.hpp"

namespace hecaton::planner {
namespace {

/// Obstacles begin anywhere in this span of their scripts [s].
constexpr double kScriptSpan = 60.0;
/// A batch whose first episodes, as many as these, could all not be drawn is given up.
constexpr int kMostInVain = 50;

struct EpisodeRecord {
  std::string missing;  ///< why its task could not be drawn; empty: it could
  EpisodeOutcome outcome;
  ClockedTimes clocked;
};

/// Of a cell whose scene is this episode's own.
EpisodeRecord run_in_scene(const Cell& cell, TaskGenerator& generator, Random random, const BatchOptions& options,
                           bool observed) {
  EpisodeRecord record;
  EpisodeOptions episode_options;
  episode_options.network = options.network;
  episode_options.world_time = random.uniform(0.0, kScriptSpan);
  episode_options.seed = random.next();
  episode_options.threads = options.threads;
  if (options.measure_ticks) episode_options.times = &record.clocked;
  const auto starts = generator.draw_configuration(random);
  const auto goals = starts ? generator.draw_conflicting_goals(random, *starts) : std::nullopt;
  if (!goals) {
    record.missing = generator.shortage();
    return record;
  }
  if (!generator.clear_at(episode_options.world_time, *starts)) {  // the stops of a route may be in an obstacle's way
    const auto time = generator.draw_time(random, kScriptSpan, *starts);
    if (!time) {
      record.missing = generator.shortage();
      return record;
    }
    episode_options.world_time = *time;
  }
  if (observed && options.observe_first) {
    episode_options.observe = [&](double time, const CellConfiguration& measured, std::span<const ArmPlanner> all) {
      options.observe_first({cell, *goals, time, measured, all});
    };
  }
  record.outcome = simulate_episode(cell, *starts, *goals, episode_options);
  return record;
}

/// Draws scenes until one admits a task.
EpisodeRecord run_in_clutter(const Cell& cell, Random random, const BatchOptions& options, bool observed) {
  constexpr int kScenes = 50;
  EpisodeRecord record;
  for (int scene = 0; scene < kScenes && (scene == 0 || !record.missing.empty()); ++scene) {
    Cell cluttered = cell;
    for (world::Obstacle& obstacle : draw_clutter(cell.tasks.clutter, random)) {
      cluttered.scene.obstacles.push_back(std::move(obstacle));
    }
    TaskGenerator generator(cluttered);
    record = run_in_scene(cluttered, generator, Random(random.next()), options, observed);
  }
  return record;
}

EpisodeRecord run_episode(const Cell& cell, TaskGenerator& generator, const BatchOptions& options, int episode,
                          bool observed) {
  // One stream of random numbers an episode, so that its tasks depend on its number alone.
  const Random random(Random(options.seed).next() + static_cast<std::uint64_t>(episode) * 0xD134'2543'DE82'EF95ULL);
  return cell.tasks.clutter.count > 0 ? run_in_clutter(cell, random, options, observed)
                                      : run_in_scene(cell, generator, random, options, observed);
}

void add(BatchReport& report, const EpisodeRecord& record, int tasks_left) {
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
  std::vector<double>& tick_us = report.clocked.tick_us;
  tick_us.insert(tick_us.end(), record.clocked.tick_us.begin(), record.clocked.tick_us.end());
  report.clocked.rollout_us += record.clocked.rollout_us;
  report.clocked.run_us += record.clocked.run_us;
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
        report.times.push_back(arm.time);
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
  }
}

}  // namespace

BatchReport simulate_tasks(const Cell& cell, const BatchOptions& options) {
  const int arms = static_cast<int>(cell.arms.size());
  const int episodes = (options.tasks + arms - 1) / arms;
  std::vector<EpisodeRecord> records(episodes);
  // A cell that admits no tasks shows it in the first ones; to find that out takes a while for each.
  TaskGenerator first(cell);
  int next_in_turn = 0;
  bool drawn = false;
  while (!drawn && next_in_turn < std::min(episodes, kMostInVain)) {
    records[next_in_turn] = run_episode(cell, first, options, next_in_turn, true);
    drawn = records[next_in_turn++].missing.empty();
  }
  if (!drawn) records.resize(next_in_turn);
  std::atomic<int> next = drawn ? next_in_turn : episodes;
  const int at_once = std::clamp(episodes - 1, 1, options.threads);
  BatchOptions each = options;
  each.threads = options.threads / at_once;
  const auto work = [&] {
    if (next >= episodes) return;
    TaskGenerator generator(cell);
    for (int episode = next++; episode < episodes; episode = next++) {
      records[episode] = run_episode(cell, generator, each, episode, false);
    }
  };
  {
    std::vector<std::jthread> workers;
    for (int k = 1; k < at_once; ++k) workers.emplace_back(work);
    work();
  }
  BatchReport report;
  for (const PlannedArm& planned : cell.arms) report.arms.push_back({.name = planned.arm.name});
  std::string missing;
  for (const EpisodeRecord& record : records) {
    if (record.missing.empty()) {
      add(report, record, options.tasks - report.tasks);
    } else if (missing.empty()) {
      missing = record.missing;
    }
  }
  if (missing.empty()) return report;
  report.failure = "cell '" + cell.name + "': ";
  report.failure += drawn ? std::to_string(report.tasks) + " of " + std::to_string(options.tasks) +
                                " tasks could be drawn; for the first of the others, "
                          : "no task could be drawn in " + std::to_string(records.size()) +
                                (records.size() == 1 ? " episode: " : " episodes: for the first, ");
  report.failure += missing;
  return report;
}

}  // namespace hecaton::planner
