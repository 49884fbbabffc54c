#pragma once
/// Strategies of a whole system that people give on the command line.

#include <string>
#include <vector>

#include "planner/strategy_search/search.hpp"
#include "services/config/cell_file.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace hecaton::services::cli {

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
