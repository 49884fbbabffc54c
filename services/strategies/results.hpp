#pragma once
/// Strategies of a whole system and what is known of them: from the command line and from files, as tables, JSON and
/// CSV.

#include <string>
#include <vector>

#include "planner/strategy_search/search.hpp"
#include "planner/strategy_search/statistics.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace hecaton::services::cli {

/// The allowed coefficients α, β, … of a strategy.
inline constexpr config::Bounds kCoefficient{-planner::kMostCoefficient, planner::kMostCoefficient, ""};

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

/// --from: α, β, …, λ of each arm, one after the other.
void add_from(CLI::App& app, std::vector<double>& from, const std::string& description);

/// What --from says; without it the strategies that the cell file gives its arms. Throws Failure (bad input).
[[nodiscard]] planner::SystemStrategy strategy_from(const std::vector<double>& from, const config::CellFile& file,
                                                    const planner::StrategyProblem& problem);

/// All combinations in which every two neighbours (first and second arm, second and third, …, of three or more also
/// last and first) are a pair that had no fault in those results of two arms (CSV): what [Mediavilla02] tried for 3A.
/// Throws Failure (bad input).
[[nodiscard]] std::vector<planner::SystemStrategy> combine_pairs(const std::string& results,
                                                                 const planner::StrategyProblem& problem);

}  // namespace hecaton::services::cli
