/// hecaton-strategies validate, hecaton-strategies simplex: evaluates one strategy, and improves it locally.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>

#include <CLI/CLI.hpp>

#include "planner/strategy_search/motion_problem.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/strategies/commands.hpp"
#include "services/strategies/results.hpp"

namespace hecaton::services::cli {
namespace {

/// Lags of the autocorrelation, as in table 1.
constexpr int kLags = 6;

struct ValidateOptions {
  std::string cell;
  std::string strategies;    ///< CSV; empty: `from`
  std::vector<double> from;  ///< empty: the strategies in the cell file
  std::size_t rank = 1;
  int tasks = 4200;
  std::uint64_t seed = 1001;
};

planner::SystemStrategy strategy_of(const ValidateOptions& options, const config::CellFile& file,
                                    const planner::StrategyProblem& problem) {
  if (options.strategies.empty()) return strategy_from(options.from, file, problem);
  const StrategyResults results = read_strategy_csv(options.strategies);
  if (options.rank > results.rows.size()) {
    throw Failure(ExitCode::kBadInput, "--rank = " + std::to_string(options.rank) + " must be at most " +
                                           std::to_string(results.rows.size()) + ", the number of strategies in " +
                                           options.strategies);
  }
  if (static_cast<int>(results.arms.size()) != problem.arms()) {
    throw Failure(ExitCode::kBadInput, options.strategies + " is of another cell: it has strategies for " +
                                           std::to_string(results.arms.size()) + " arms; this cell has " +
                                           std::to_string(problem.arms()));
  }
  planner::SystemStrategy strategy;
  const StrategyRow& row = results.rows[options.rank - 1];
  for (int arm = 0; arm < problem.arms(); ++arm) {
    const auto name = std::find(results.arms.begin(), results.arms.end(), problem.name_of(arm));
    if (name == results.arms.end()) {
      throw Failure(ExitCode::kBadInput, options.strategies + " has no strategy for arm " + problem.name_of(arm));
    }
    const auto at = name - results.arms.begin();
    if (row.coefficients[at] != problem.coefficients(arm)) {
      throw Failure(ExitCode::kBadInput, options.strategies + ": arm " + problem.name_of(arm) + " must have " +
                                             std::to_string(problem.coefficients(arm)) + " coefficients, not " +
                                             std::to_string(row.coefficients[at]));
    }
    strategy.push_back(row.strategy[at]);
  }
  return strategy;
}

Json numbers(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(value);
  return list;
}

std::string numbers_text(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + decimal_text(value, 3);
  return text;
}

/// For a signal before the first result.
[[noreturn]] void throw_interrupted(const Interruption& interruption) {
  const Interrupted interrupted{interruption.signal(), 0, 1, "evaluations"};
  throw Failure(interrupted.exit_code(), interrupted.text());
}

ExitCode validate(const Settings& settings, const ValidateOptions& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  std::vector<std::vector<std::int32_t>> times;
  StrategyResults results;
  planner::Evaluation evaluation;
  const Interruption interruption;
  Progress progress;
  try {
    const planner::StrategyProblem problem(file.cell);
    const planner::SystemStrategy strategy = strategy_of(options, file, problem);
    const double all = static_cast<double>(options.tasks) * problem.arms();
    const auto ended = [&](std::int64_t tasks) {
      constexpr std::int64_t kShownEvery = 64;  // tasks
      if (tasks % kShownEvery == 0) progress.show("validate", static_cast<double>(tasks), all, "tasks");
      return interruption.requested();
    };
    evaluation =
        evaluate(problem, problem.draw(options.seed, options.tasks), strategy, {.times = &times, .ended = ended});
    progress.clear();
    if (evaluation.all_tasks() == 0) throw_interrupted(interruption);
    results = strategy_results(problem, {{strategy, evaluation}});
  } catch (const planner::ProblemError& error) {
    throw Failure(ExitCode::kBadInput, file.path + ": " + error.what());
  }

  Table table({{"arm"},
               {"faults", Align::kRight},
               {"mean t", Align::kRight},
               {"std t", Align::kRight},
               {"autocorrelation of t, lags 1 to 6"}});
  Json arms = Json::array();
  for (std::size_t arm = 0; arm < results.arms.size(); ++arm) {
    const planner::Moments moments = planner::moments(times[arm]);
    const std::vector<double> own = planner::correlations(times[arm], times[arm], kLags);
    table.add({results.arms[arm], std::to_string(evaluation.faults[arm]), decimal_text(moments.mean, 2),
               decimal_text(moments.deviation, 2), numbers_text(own)});
    arms.push_back({{"name", results.arms[arm]},
                    {"tasks", evaluation.tasks[arm]},
                    {"faults", evaluation.faults[arm]},
                    {"mean_steps", moments.mean},
                    {"std_steps", moments.deviation},
                    {"autocorrelation", numbers(own)}});
  }
  Json pairs = Json::array();
  std::string text =
      strategy_table(results, 1, Palette::for_stream(stdout)) + "\n" + table.text(Palette::for_stream(stdout)) + "\n";
  for (std::size_t a = 0; a < results.arms.size(); ++a) {
    for (std::size_t b = a + 1; b < results.arms.size(); ++b) {
      const std::size_t both = std::min(times[a].size(), times[b].size());
      const double value = planner::correlation(std::span(times[a]).first(both), std::span(times[b]).first(both));
      pairs.push_back({{"arms", {results.arms[a], results.arms[b]}}, {"correlation", value}});
      text += "correlation of " + results.arms[a] + " and " + results.arms[b] + ": " + decimal_text(value, 3) + "\n";
    }
  }
  // Of all arms, as many as were asked for unless interrupted.
  const std::int64_t asked = static_cast<std::int64_t>(options.tasks) * static_cast<std::int64_t>(results.arms.size());
  const std::optional<Interrupted> interrupted =
      evaluation.complete ? std::nullopt : interruption.after(evaluation.all_tasks(), asked, "tasks");
  const auto fewest = static_cast<double>(*std::min_element(evaluation.tasks.begin(), evaluation.tasks.end()));
  const double significant = 2.0 / std::sqrt(std::max(1.0, fewest));
  text += "95 % limits for independent times: ±2/√N = " + decimal_text(significant, 3) + "\n";
  const Json value = {{"cell", file.cell.name},
                      {"seed", options.seed},
                      {"tasks", options.tasks},
                      {"strategy", strategy_json(results, 1).front()},
                      {"arms", arms},
                      {"correlations", pairs},
                      {"two_over_sqrt_n", significant},
                      {"interrupted", to_json(interrupted)}};
  if (interrupted) text += interrupted->text() + "\n";
  print(settings, value, text);
  if (interrupted) return interrupted->exit_code();
  return results.rows.front().faults == 0 ? ExitCode::kDone : ExitCode::kNegative;
}

struct RefineOptions {
  std::string cell;
  std::vector<double> from;
  int tasks = 600;
  std::uint64_t seed = 1;
  planner::SimplexOptions simplex;
};

ExitCode refine(const Settings& settings, const RefineOptions& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  const auto began = std::chrono::steady_clock::now();
  StrategyResults results;
  planner::SimplexResult found;
  const Interruption interruption;
  Progress progress;
  bool ended = false;
  try {
    const planner::StrategyProblem problem(file.cell);
    const planner::SystemStrategy initial = strategy_from(options.from, file, problem);
    planner::TaskSet tasks = problem.draw(options.seed, options.tasks);
    problem.precheck_paths(tasks);
    planner::SimplexOptions simplex = options.simplex;
    simplex.ended = [&](int steps) {
      progress.show("simplex", steps, simplex.max_steps, "evaluations at most");
      ended = interruption.requested();
      return ended;
    };
    found = refine_by_simplex(problem, tasks, initial, simplex);
    progress.clear();
    results = strategy_results(problem, {{initial, found.initial}, {found.strategy, found.final}});
  } catch (const planner::ProblemError& error) {
    throw Failure(ExitCode::kBadInput, file.path + ": " + error.what());
  }
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
  const std::optional<Interrupted> interrupted =
      ended ? interruption.after(found.steps, options.simplex.max_steps, "evaluations") : std::nullopt;
  const Json both = strategy_json(results, 2);
  const Json value = {{"cell", file.cell.name},
                      {"seed", options.seed},
                      {"initial", both[0]},
                      {"optimum", both[1]},
                      {"evaluations", found.steps},
                      {"tolerance_steps", options.simplex.tolerance},
                      {"interrupted", to_json(interrupted)}};
  print(settings, value,
        strategy_table(results, 2, Palette::for_stream(stdout)) + "\n1: initial strategy; 2: the best of " +
            std::to_string(found.steps) + " evaluations\n" + (interrupted ? interrupted->text() + "\n" : ""));
  std::fprintf(stderr, "%s\n", duration_text(spent.count()).c_str());
  if (interrupted) return interrupted->exit_code();
  return results.rows.back().faults == 0 ? ExitCode::kDone : ExitCode::kNegative;
}

}  // namespace

void add_validate(CLI::App& parent, Session& session) {
  CLI::App* command = parent.add_subcommand(
      "validate", "Simulates one strategy on new tasks: faults with bounds, times and their correlations");
  auto options = std::make_shared<ValidateOptions>();
  command->add_option("CELL", options->cell, "cell file (YAML) with tasks.areas")->required();
  command
      ->add_option("--strategies", options->strategies, "results (CSV) of a search (the strategies in the cell file)")
      ->type_name("FILE");
  add_from(*command, options->from,
           "the strategy: coefficients and direction of each arm in turn: \"0 -2.5 1 2 -2.5 1\"");
  command->get_option("--from")->excludes("--strategies");
  add_whole_number(
      *command, "--rank", [options](std::uint64_t n) { options->rank = n; }, "rank in the results; 1 is the best (1)",
      1, 1'000'000);
  add_whole_number(
      *command, "--tasks", [options](std::uint64_t n) { options->tasks = static_cast<int>(n); },
      "tasks of each arm (4200)", 1, 10'000'000);
  add_seed(*command, options->seed, "of the tasks; must not be that of a search (1001)");
  command->footer(
      "P at most: upper bound of the probability of a fault with 97.5 % confidence (the upper end of the exact "
      "binomial 95 % interval). Exit code 1 if there was a fault.");
  command->callback(
      [&session, options] { session.action = [&session, options] { return validate(session.settings, *options); }; });
}

void add_simplex(CLI::App& parent, Session& session) {
  CLI::App* command = parent.add_subcommand(
      "simplex", "Improves one strategy locally by the simplex method of Nelder and Mead; keeps the directions");
  auto options = std::make_shared<RefineOptions>();
  command->add_option("CELL", options->cell, "cell file (YAML) with tasks.areas")->required();
  add_from(*command, options->from,
           "coefficients and direction of each arm in turn: \"0 -2.5 1 2 -2.5 1\" (the strategies in the cell file)");
  add_whole_number(
      *command, "--tasks", [options](std::uint64_t n) { options->tasks = static_cast<int>(n); },
      "tasks of each arm, the same in all evaluations (600)", 1, 1'000'000);
  add_whole_number(
      *command, "--steps", [options](std::uint64_t n) { options->simplex.max_steps = static_cast<int>(n); },
      "largest number of evaluations (200)", 1, 1'000'000);
  constexpr config::Bounds kTolerance{0.0, 1e6, "steps", true};
  add_number(
      *command, "--tolerance", [options](double x) { options->simplex.tolerance = x; },
      "stop when T(L) differs by less within the simplex (0.5)", kTolerance);
  add_seed(*command, options->seed, "of the tasks (1)");
  command->footer("Exit code 1 if the best strategy had a fault.");
  command->callback(
      [&session, options] { session.action = [&session, options] { return refine(session.settings, *options); }; });
}

}  // namespace hecaton::services::cli
