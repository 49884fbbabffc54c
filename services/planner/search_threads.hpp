#pragma once
/// Runs the searches of an arm (rollouts, routes, coupled plans) in background threads, so that they do not delay
/// commands.

#include <memory>
#include <optional>
#include <string>

#include "planner/arm_planner/search_executor.hpp"
#include "planner/cell.hpp"
#include "services/runtime/progress_watchdog.hpp"

namespace hecaton::services {

/// All functions are for the thread of the control loop and do not wait, except the destructor. Rollouts get a fixed
/// number of ticks per control period.
class SearchThreads : public planner::SearchExecutor {
 public:
  /// `self`: index of the own arm.
  SearchThreads(const planner::Cell& cell, int self);
  /// Waits for the present searches and drops other questions.
  ~SearchThreads() override;

  [[nodiscard]] planner::SearchAnswers answers() override;
  void ask(planner::SearchQuestions questions, const planner::SharedObstacles& obstacles) override;

  /// A sentence about a thread that has finished nothing for longer than any search takes; empty: none. Call it every
  /// period.
  [[nodiscard]] std::optional<std::string> stalled(ProgressWatchdog::Clock::time_point now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
