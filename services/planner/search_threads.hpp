#pragma once
/// Runs an arm's searches on threads of their own, so that they never delay a command. Rollouts get a share in every
/// control period, and never take more of a processor. The loop never waits for a thread, which may be without a
/// processor while it holds the lock.

#include <memory>
#include <optional>
#include <string>

#include "planner/arm_planner/search_executor.hpp"
#include "planner/cell.hpp"
#include "services/runtime/turn_watch.hpp"

namespace hecaton::services {

class SearchThreads : public planner::SearchExecutor {
 public:
  /// `self`: index of the own arm.
  SearchThreads(const planner::Cell& cell, int self);
  /// Waits for the searches under way, and drops other questions.
  ~SearchThreads() override;

  [[nodiscard]] planner::SearchAnswers answers() override;
  void ask(planner::SearchQuestions questions, const planner::SharedObstacles& obstacles) override;

  /// To be called every period: a thread that has something to do and has finished nothing for longer than any search
  /// takes, in a sentence.
  [[nodiscard]] std::optional<std::string> hanging(TurnWatch::Clock::time_point now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
