#pragma once
/// What a search for strategies has done so far: a bar on stderr, and a file from which it can go on.

#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <string>
#include <utility>

#include "planner/strategy_search/search.hpp"

namespace hecaton::services::cli {

class StrategyProgress {
 public:
  /// `path` empty: no file. With `resume`, evaluations in the file are not made again; throws Failure when it belongs
  /// to another search.
  StrategyProgress(const std::string& path, bool resume, const planner::StrategyProblem& problem,
                   const planner::SearchPlan& plan, const planner::StrategyGrid& grid);

  /// Lets the search tell.
  void hook(planner::SearchHooks& hooks);
  /// Ends the bar's line.
  void end();

 private:
  using Key = std::pair<std::uint64_t, std::size_t>;  ///< seed of the round, index
  void read(const std::string& path, const std::string& title);
  void show(const planner::Round& round, std::size_t all);

  std::ofstream file_;
  std::map<Key, planner::Evaluation> known_;
  bool terminal_;
  std::uint64_t seed_ = 0;  ///< of the round that is shown
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point began_;
  std::chrono::steady_clock::time_point shown_;
};

}  // namespace hecaton::services::cli
