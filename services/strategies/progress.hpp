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

/// What a search's evaluations depend on: another title, another search.
[[nodiscard]] std::string search_title(const planner::StrategyProblem& problem, const planner::SearchPlan& plan,
                                       const std::vector<planner::SystemStrategy>& candidates);
/// What the file of an earlier, interrupted run has under its title. Throws Failure when it is of another search.
[[nodiscard]] std::string search_so_far(const std::string& path, const std::string& title);

class StrategyProgress {
 public:
  StrategyProgress();
  /// Evaluations go to that file, too; throws Failure when it cannot be written.
  void keep(const std::string& path, const std::string& title);
  /// Evaluations in search_so_far() are not made again.
  void know(const std::string& so_far);

  /// Now and then a line on stderr where it is no terminal: mpirun passes it on to people.
  void tell_in_lines(bool lines) { lines_ = lines && !terminal_; }
  /// Lets the search tell.
  void hook(planner::SearchHooks& hooks);
  /// Ends the bar's line.
  void end();

 private:
  using Key = std::pair<std::uint64_t, std::size_t>;  ///< seed of the round, index
  void show(const planner::Round& round, std::size_t all);

  std::ofstream file_;
  std::map<Key, planner::Evaluation> known_;
  bool terminal_;
  bool lines_ = false;
  std::uint64_t seed_ = 0;  ///< of the round that is shown
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point began_;
  std::chrono::steady_clock::time_point shown_;
  std::chrono::steady_clock::time_point said_;
};

}  // namespace hecaton::services::cli
