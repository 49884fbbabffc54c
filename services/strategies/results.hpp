#pragma once
/// Results of a strategy search: read from and written to CSV, tables, JSON and YAML.

#include <string>
#include <vector>

#include "planner/strategy_search/evaluate.hpp"
#include "planner/strategy_search/search.hpp"
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
  std::vector<int> coefficients;  ///< number, by arm
  std::int64_t tasks = 0;         ///< of all arms
  std::int64_t faults = 0;
  double time = 0.0;   ///< T(L) [steps]
  double error = 0.0;  ///< standard error of `time` [steps]

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

/// The first `count` rows.
[[nodiscard]] std::string strategy_table(const StrategyResults& results, std::size_t count, const Palette& palette);
[[nodiscard]] Json strategy_json(const StrategyResults& results, std::size_t count);

/// CSV with a line of titles: rank, T, its error, tasks, faults, and for each arm its direction and coefficients.
[[nodiscard]] std::string strategy_csv(const StrategyResults& results);
/// Throws Failure (bad input) that names file and line.
[[nodiscard]] StrategyResults read_strategy_csv(const std::string& path);

/// The best row, for `strategy: {file: …}` in a cell file.
[[nodiscard]] std::string strategy_yaml(const StrategyResults& results, const std::string& cell);

/// Adds --from: α, β, …, λ of each arm in turn.
void add_from(CLI::App& app, std::vector<double>& from, const std::string& description);

/// The strategy given by --from or, if it is empty, by the cell file. Throws Failure (bad input).
[[nodiscard]] planner::SystemStrategy strategy_from(const std::vector<double>& from, const config::CellFile& file,
                                                    const planner::StrategyProblem& problem);

/// Combines the results of two arms (CSV) for more arms, as [Mediavilla02] does for 3A: all combinations in which
/// each two neighbours are a pair without fault. Neighbours are arms 1 and 2, 2 and 3, …; with three or more arms,
/// also the last and the first. Throws Failure (bad input).
[[nodiscard]] std::vector<planner::SystemStrategy> combine_pairs(const std::string& results,
                                                                 const planner::StrategyProblem& problem);

}  // namespace hecaton::services::cli
