#pragma once
/// Strategies and what is known of them, as tables, JSON and CSV.

#include <string>
#include <vector>

#include "planner/strategy_search/search.hpp"
#include "planner/strategy_search/statistics.hpp"
#include "services/cli/document.hpp"
#include "services/cli/terminal.hpp"

namespace hecaton::services::cli {

/// One line of a results file.
struct StrategyRow {
  planner::SystemStrategy strategy;
  std::vector<int> coefficients;  ///< of each arm
  std::int64_t tasks = 0;         ///< of all arms
  std::int64_t faults = 0;
  double time = 0.0;   ///< T(L) [steps]
  double error = 0.0;  ///< its standard error [steps]

  [[nodiscard]] planner::FaultBounds bounds() const { return planner::fault_bounds(faults, tasks); }
};

struct StrategyResults {
  std::vector<std::string> arms;  ///< names
  std::vector<StrategyRow> rows;  ///< best first
};

[[nodiscard]] StrategyRow strategy_row(const planner::StrategyProblem& problem, const planner::SystemStrategy& strategy,
                                       const planner::Evaluation& evaluation);
[[nodiscard]] StrategyResults strategy_results(const planner::StrategyProblem& problem,
                                               const std::vector<planner::Candidate>& candidates);

/// "(2, -1) +"
[[nodiscard]] std::string strategy_text(const planner::Strategy& strategy, int coefficients);

/// The first `most` rows.
[[nodiscard]] std::string strategy_table(const StrategyResults& results, std::size_t most, const Palette& palette);
[[nodiscard]] Json strategy_json(const StrategyResults& results, std::size_t most);

/// CSV: a line of titles, then rank, T, its error, tasks, faults, and for each arm its direction and coefficients.
[[nodiscard]] std::string strategy_csv(const StrategyResults& results);
/// Throws Failure (bad input) that names file and line.
[[nodiscard]] StrategyResults read_strategy_csv(const std::string& path);

/// For `strategy: {file: …}` in a cell file: the best row. Throws Failure when the file cannot be written.
[[nodiscard]] std::string strategy_yaml(const StrategyResults& results, const std::string& cell);

}  // namespace hecaton::services::cli
