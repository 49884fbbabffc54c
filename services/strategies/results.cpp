#include "services/strategies/results.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include <CLI/CLI.hpp>

#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

const std::vector<std::string> kFixedTitles = {"rank", "time", "time_error", "tasks", "faults"};

std::string exact(double value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  return out.str();
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> words;
  std::stringstream stream(line);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

/// A column "south_direction", "south_1", "south_2", …
struct ArmColumn {
  std::size_t arm;
  int coefficient;  ///< −1: the direction
};

std::vector<ArmColumn> arm_columns(const std::vector<std::string>& titles, StrategyResults& results,
                                   const std::function<void(const std::string&)>& fail) {
  std::vector<ArmColumn> columns;
  for (std::size_t i = kFixedTitles.size(); i < titles.size(); ++i) {
    const std::size_t cut = titles[i].rfind('_');
    const std::string arm = cut == std::string::npos ? "" : titles[i].substr(0, cut);
    const std::string what = cut == std::string::npos ? "" : titles[i].substr(cut + 1);
    if (what == "direction") results.arms.push_back(arm);
    const bool own = !results.arms.empty() && results.arms.back() == arm && !arm.empty();
    const int coefficient = columns.empty() || what == "direction" ? -1 : columns.back().coefficient + 1;
    if (!own || (coefficient >= 0 && what != std::to_string(coefficient + 1)) ||
        coefficient >= planner::kMaxJoints - 2) {
      fail("column '" + config::printable(titles[i]) + "' must be ARM_direction or ARM_1, ARM_2, …");
    }
    columns.push_back({results.arms.size() - 1, coefficient});
  }
  if (columns.empty()) fail("the first line must have the columns of an arm");
  return columns;
}

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
                                             std::to_string(coefficients) + " coefficients, as the arms of this cell");
    }
    if (row.faults > 0 || has(pairs, row.strategy[0], row.strategy[1])) continue;
    pairs.emplace_back(row.strategy[0], row.strategy[1]);
  }
  return pairs;
}

}  // namespace

StrategyRow strategy_row(const planner::StrategyProblem& problem, const planner::SystemStrategy& strategy,
                         const planner::Evaluation& evaluation) {
  StrategyRow row;
  row.strategy = strategy;
  for (int arm = 0; arm < problem.arms(); ++arm) row.coefficients.push_back(problem.coefficients(arm));
  row.tasks = evaluation.all_tasks();
  row.faults = evaluation.all_faults();
  row.time = evaluation.mean_time();
  row.error = evaluation.mean_time_error();
  return row;
}

StrategyResults strategy_results(const planner::StrategyProblem& problem,
                                 const std::vector<planner::Candidate>& candidates) {
  StrategyResults results;
  for (int arm = 0; arm < problem.arms(); ++arm) results.arms.push_back(problem.name_of(arm));
  for (const planner::Candidate& candidate : candidates) {
    results.rows.push_back(strategy_row(problem, candidate.strategy, candidate.evaluation));
  }
  return results;
}

std::string strategy_text(const planner::Strategy& strategy, int coefficients) {
  std::string text = "(";
  for (int k = 0; k < coefficients; ++k) text += (k > 0 ? ", " : "") + config::number_text(strategy.coefficients[k]);
  return text + (strategy.direction > 0.0 ? ") +" : ") -");
}

std::string strategy_table(const StrategyResults& results, std::size_t count, const Palette& palette) {
  std::vector<Table::Column> columns = {{"rank", Align::kRight}};
  for (const std::string& arm : results.arms) columns.push_back({arm + " (α, β) λ"});
  for (const char* title : {"T [steps]", "±", "faults", "tasks", "P at most (95 %)"}) {
    columns.push_back({title, Align::kRight});
  }
  Table table(columns);
  for (std::size_t i = 0; i < std::min(count, results.rows.size()); ++i) {
    const StrategyRow& row = results.rows[i];
    std::vector<std::string> cells = {std::to_string(i + 1)};
    for (std::size_t arm = 0; arm < row.strategy.size(); ++arm) {
      cells.push_back(strategy_text(row.strategy[arm], row.coefficients[arm]));
    }
    cells.push_back(decimal_text(row.time, 2));
    cells.push_back(decimal_text(row.error, 2));
    cells.push_back(std::to_string(row.faults));
    cells.push_back(std::to_string(row.tasks));
    cells.push_back(decimal_text(100.0 * row.bounds().high, 3) + " %");
    table.add(std::move(cells));
  }
  return table.text(palette);
}

Json strategy_json(const StrategyResults& results, std::size_t count) {
  Json list = Json::array();
  for (std::size_t i = 0; i < std::min(count, results.rows.size()); ++i) {
    const StrategyRow& row = results.rows[i];
    Json arms = Json::array();
    for (std::size_t arm = 0; arm < row.strategy.size(); ++arm) {
      Json numbers = Json::array();
      for (int k = 0; k < row.coefficients[arm]; ++k) numbers.push_back(row.strategy[arm].coefficients[k]);
      arms.push_back({{"name", results.arms[arm]},
                      {"coefficients", numbers},
                      {"direction", row.strategy[arm].direction > 0.0 ? 1 : -1}});
    }
    const planner::FaultBounds bounds = row.bounds();
    list.push_back({{"rank", i + 1},
                    {"arms", arms},
                    {"time_steps", row.time},
                    {"time_error_steps", row.error},
                    {"tasks", row.tasks},
                    {"faults", row.faults},
                    {"fault_bounds", {bounds.low, bounds.high}}});
  }
  return list;
}

std::string strategy_csv(const StrategyResults& results) {
  std::string text;
  const auto add = [&text](const std::vector<std::string>& words) {
    for (std::size_t i = 0; i < words.size(); ++i) text += (i > 0 ? "," : "") + words[i];
    text += '\n';
  };
  std::vector<std::string> titles = kFixedTitles;
  for (std::size_t arm = 0; arm < results.arms.size(); ++arm) {
    titles.push_back(results.arms[arm] + "_direction");
    const int coefficients = results.rows.empty() ? 0 : results.rows.front().coefficients[arm];
    for (int k = 0; k < coefficients; ++k) titles.push_back(results.arms[arm] + "_" + std::to_string(k + 1));
  }
  add(titles);
  for (std::size_t i = 0; i < results.rows.size(); ++i) {
    const StrategyRow& row = results.rows[i];
    std::vector<std::string> words = {std::to_string(i + 1), exact(row.time), exact(row.error),
                                      std::to_string(row.tasks), std::to_string(row.faults)};
    for (std::size_t arm = 0; arm < row.strategy.size(); ++arm) {
      words.emplace_back(row.strategy[arm].direction > 0.0 ? "1" : "-1");
      for (int k = 0; k < row.coefficients[arm]; ++k) words.push_back(exact(row.strategy[arm].coefficients[k]));
    }
    add(words);
  }
  return text;
}

StrategyResults read_strategy_csv(const std::string& path) {
  std::ifstream file(path);
  if (!file || file.peek() == std::ifstream::traits_type::eof()) {
    throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be read, or is empty");
  }
  int number = 0;
  const auto fail = [&](const std::string& says) {
    throw Failure(ExitCode::kBadInput, path + ": line " + std::to_string(number) + ": " + says);
  };
  StrategyResults results;
  std::vector<ArmColumn> columns;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const std::vector<std::string> words = split(line);
    if (number == 1) {
      if (words.size() < kFixedTitles.size() || !std::equal(kFixedTitles.begin(), kFixedTitles.end(), words.begin())) {
        fail(
            "the first line must begin with rank,time,time_error,tasks,faults, as `hecaton-strategies search` writes "
            "it");
      }
      columns = arm_columns(words, results, fail);
      continue;
    }
    if (words.size() != kFixedTitles.size() + columns.size()) fail("must have as many values as the first line");
    std::vector<double> values;
    for (const std::string& word : words) {
      const auto value = config::parse_number(word);
      if (!value || !std::isfinite(*value)) fail("'" + config::printable(word) + "' must be a finite number");
      values.push_back(*value);
    }
    StrategyRow row;
    row.time = values[1];
    row.error = values[2];
    constexpr double kMaxCount = 1e15;
    if (std::abs(values[3]) > kMaxCount || std::abs(values[4]) > kMaxCount)
      fail("tasks and faults must be at most 1e15");
    row.tasks = static_cast<std::int64_t>(values[3]);
    row.faults = static_cast<std::int64_t>(values[4]);
    if (row.tasks < 1 || row.faults < 0 || row.faults > row.tasks) {
      fail("tasks must be at least 1, and faults at most as many as tasks");
    }
    row.strategy.resize(results.arms.size());
    row.coefficients.assign(results.arms.size(), 0);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double value = values[kFixedTitles.size() + i];
      planner::Strategy& strategy = row.strategy[columns[i].arm];
      if (columns[i].coefficient < 0) {
        if (std::abs(value) != 1.0) fail("a direction must be 1 or -1");
        strategy.direction = value;
      } else {
        if (!kCoefficient.allow(value)) {
          fail("a coefficient must be a number " + kCoefficient.text());
        }
        strategy.coefficients[columns[i].coefficient] = value;
        row.coefficients[columns[i].arm] = columns[i].coefficient + 1;
      }
    }
    results.rows.push_back(std::move(row));
  }
  if (results.rows.empty()) fail("the file has no strategy");
  return results;
}

std::string strategy_yaml(const StrategyResults& results, const std::string& cell) {
  std::string text = "# Written by hecaton-strategies search for the cell " + cell + ".\n";
  if (results.rows.empty()) return text;
  const StrategyRow& best = results.rows.front();
  text += "# " + std::to_string(best.faults) + " faults in " + std::to_string(best.tasks) +
          " tasks; T = " + config::number_text(best.time) + " steps\n";
  for (std::size_t arm = 0; arm < best.strategy.size(); ++arm) {
    std::vector<std::string> numbers;
    text += results.arms[arm] + ": {coefficients: [";
    for (int k = 0; k < best.coefficients[arm]; ++k) {
      text += (k > 0 ? ", " : "") + exact(best.strategy[arm].coefficients[k]);
    }
    text += std::string("], direction: ") + (best.strategy[arm].direction > 0.0 ? "1" : "-1") + "}\n";
  }
  return text;
}

void add_from(CLI::App& app, std::vector<double>& from, const std::string& description) {
  add_numbers(app, "--from", from, 0, description, kCoefficient);
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
                                           " give no combination for the arms of this cell");
  }
  return chains;
}

}  // namespace hecaton::services::cli
