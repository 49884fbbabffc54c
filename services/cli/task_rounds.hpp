#pragma once
/// Gives all arms of a running cell conflicting goals, round by round, until a number of tasks has ended.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planner/simulation/tasks.hpp"
#include "services/cli/running_cell.hpp"
#include "services/cli/task_report.hpp"

namespace hecaton::services::cli {

/// The task of one arm in one round.
struct Task {
  std::shared_ptr<client::GoalRecord> goal;
  std::optional<msg::GoalStatus> status;  ///< newest
  bool counted = true;  ///< false: beyond the number of tasks, given only so that every arm has a goal
  bool ended = false;
  std::string outcome;  ///< "reached", "blocked" or "timed_out", once it has ended
};

/// Gives the goals and counts the outcomes. For one thread.
class TaskRounds {
 public:
  struct Options {
    int tasks = 0;
    std::uint64_t seed = 1;
  };
  /// `show` is called several times a second while arms move, `tell` with a sentence at the end of each round.
  struct Callbacks {
    std::function<void()> show;
    std::function<void(const std::string&)> tell;
  };
  TaskRounds(RunningCell& cell, const Options& options, Callbacks callbacks);

  /// Runs until all tasks have ended, until a signal comes, or until no goals can be drawn: tally().findings then says
  /// why. Throws Failure when the cell has failed.
  void run();

  /// So far: tasks, outcomes, times, arms, missed tasks.
  [[nodiscard]] const Report& tally() const { return tally_; }
  [[nodiscard]] int rounds() const { return rounds_; }

 private:
  /// False: no goals could be drawn.
  [[nodiscard]] bool start_round();
  void update();
  void cancel_when_stalled(client::Clock::time_point now);
  void end(Task& task, const std::string& outcome);
  [[nodiscard]] bool round_is_over() const;
  [[nodiscard]] planner::CellConfiguration measured() const;
  [[nodiscard]] std::string round_text() const;

  RunningCell& cell_;
  Options options_;
  Callbacks callbacks_;
  planner::TaskGenerator generator_;
  planner::Random random_;
  std::vector<Task> round_;
  Report tally_;
  int rounds_ = 0;
  int given_ = 0;  ///< tasks that were given, over all rounds
  std::optional<client::Clock::time_point> stalled_since_;
};

}  // namespace hecaton::services::cli
