#include "services/cli/strategy_choice.hpp"

#include <cmath>

#include <CLI/CLI.hpp>

#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/cli/strategy_table.hpp"
#include "services/config/read_parameters.hpp"

namespace hecaton::services::cli {
namespace {

using Pair = std::pair<planner::Strategy, planner::Strategy>;

bool has(const std::vector<Pair>& pairs, const planner::Strategy& first, const planner::Strategy& second) {
  return std::find(pairs.begin(), pairs.end(), Pair(first, second)) != pairs.end();
}

std::vector<Pair> faultless_pairs(const std::string& path, int coefficients) {
  const StrategyResults results = read_strategy_csv(path);
  if (results.arms.size() != 2) {
    throw Failure(ExitCode::kBadInput, "--combine: " + path + " must have the strategies of two arms, not of " +
                                           std::to_string(results.arms.size()));
  }
  std::vector<Pair> pairs;
  for (const StrategyRow& row : results.rows) {
    if (row.coefficients[0] != coefficients || row.coefficients[1] != coefficients) {
      throw Failure(ExitCode::kBadInput, "--combine: " + path + " must have strategies with " +
                                             std::to_string(coefficients) + " coefficients, as this cell's arms");
    }
    if (row.faults > 0 || has(pairs, row.strategy[0], row.strategy[1])) continue;
    pairs.emplace_back(row.strategy[0], row.strategy[1]);
  }
  return pairs;
}

}  // namespace

void add_from(CLI::App& app, std::vector<double>& from, const std::string& description) {
  add_numbers(app, "--from", from, 0, description, config::kCoefficient);
}

planner::SystemStrategy strategy_from(const std::vector<double>& from, const config::CellFile& file,
                                      const planner::StrategyProblem& problem) {
  planner::SystemStrategy strategy(problem.arms());
  if (from.empty()) {
    for (int arm = 0; arm < problem.arms(); ++arm) {
      const auto own = planner::parameters_of<planner::StrategyParameters>(file.cell.arms[arm].methods);
      if (own.coefficients != problem.coefficients(arm)) {
        throw Failure(ExitCode::kBadInput, file.path + ": arm " + problem.name_of(arm) + " has no strategy of " +
                                               std::to_string(problem.coefficients(arm)) + " coefficients");
      }
      strategy[arm] = own.strategy;
    }
    return strategy;
  }
  std::size_t numbers = 0;
  for (int arm = 0; arm < problem.arms(); ++arm) numbers += static_cast<std::size_t>(problem.coefficients(arm)) + 1;
  if (from.size() != numbers) {
    throw Failure(ExitCode::kBadInput, "--from must be " + std::to_string(numbers) +
                                           " numbers for this cell: the coefficients and the direction of each arm");
  }
  std::size_t at = 0;
  for (int arm = 0; arm < problem.arms(); ++arm) {
    for (int k = 0; k < problem.coefficients(arm); ++k) strategy[arm].coefficients[k] = from[at++];
    strategy[arm].direction = from[at++];
    if (std::abs(strategy[arm].direction) != 1.0) {
      throw Failure(ExitCode::kBadInput, "--from: the direction of arm " + problem.name_of(arm) + " must be 1 or -1");
    }
  }
  return strategy;
}

std::vector<planner::SystemStrategy> combine_pairs(const std::string& results,
                                                   const planner::StrategyProblem& problem) {
  const std::vector<Pair> pairs = faultless_pairs(results, problem.coefficients(0));
  std::vector<planner::SystemStrategy> chains;
  for (const auto& [first, second] : pairs) chains.push_back({first, second});
  for (int arm = 2; arm < problem.arms(); ++arm) {
    std::vector<planner::SystemStrategy> longer;
    for (const planner::SystemStrategy& chain : chains) {
      for (const auto& [first, second] : pairs) {
        if (!(first == chain.back())) continue;
        longer.push_back(chain);
        longer.back().push_back(second);
      }
    }
    chains = std::move(longer);
  }
  if (problem.arms() > 2) {
    std::erase_if(chains,
                  [&](const planner::SystemStrategy& chain) { return !has(pairs, chain.back(), chain.front()); });
  }
  if (chains.empty()) {
    throw Failure(ExitCode::kBadInput, "--combine: the pairs without fault in " + results +
                                           " make no combination for the arms of this cell");
  }
  return chains;
}

}  // namespace hecaton::services::cli
