#include "services/cli/strategy_table.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/cli/table.hpp"
#include "services/config/read_parameters.hpp"
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

/// "south_direction", "south_1", "south_2": whose column it is, and which.
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
  if (columns.empty()) fail("the first line must name columns for an arm at least");
  return columns;
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

std::string strategy_table(const StrategyResults& results, std::size_t most, const Palette& palette) {
  std::vector<Table::Column> columns = {{"rank", Align::kRight}};
  for (const std::string& arm : results.arms) columns.push_back({arm + " (α, β) λ"});
  for (const char* title : {"T [steps]", "±", "faults", "tasks", "P at most (95 %)"}) {
    columns.push_back({title, Align::kRight});
  }
  Table table(columns);
  for (std::size_t i = 0; i < std::min(most, results.rows.size()); ++i) {
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

Json strategy_json(const StrategyResults& results, std::size_t most) {
  Json list = Json::array();
  for (std::size_t i = 0; i < std::min(most, results.rows.size()); ++i) {
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
        fail("the first line must begin with rank,time,time_error,tasks,faults, as `strategies search` writes it");
      }
      columns = arm_columns(words, results, fail);
      continue;
    }
    if (words.size() != kFixedTitles.size() + columns.size()) fail("it must have as many values as the first line");
    std::vector<double> values;
    for (const std::string& word : words) {
      const auto value = config::parse_number(word);
      if (!value || !std::isfinite(*value)) fail("'" + config::printable(word) + "' must be a finite number");
      values.push_back(*value);
    }
    StrategyRow row;
    row.time = values[1];
    row.error = values[2];
    constexpr double kMost = 1e15;
    if (std::abs(values[3]) > kMost || std::abs(values[4]) > kMost) fail("no search has so many tasks or faults");
    row.tasks = static_cast<std::int64_t>(values[3]);
    row.faults = static_cast<std::int64_t>(values[4]);
    if (row.tasks < 1 || row.faults < 0 || row.faults > row.tasks) {
      fail("tasks must be 1 or more, and faults at most as many");
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
        if (!config::kCoefficient.allow(value)) {
          fail("a coefficient must be a number " + config::kCoefficient.text());
        }
        strategy.coefficients[columns[i].coefficient] = value;
        row.coefficients[columns[i].arm] = columns[i].coefficient + 1;
      }
    }
    results.rows.push_back(std::move(row));
  }
  if (results.rows.empty()) fail("it must have a strategy at least");
  return results;
}

std::string strategy_yaml(const StrategyResults& results, const std::string& cell) {
  std::string text = "# Written by hecaton strategies search for the cell " + cell + ".\n";
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

}  // namespace hecaton::services::cli
