#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "planner/strategy_search/flat_arm.hpp"
#include "planner/strategy_search/simplex.hpp"
#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/cli/strategy_choice.hpp"
#include "services/cli/strategy_simplex.hpp"
#include "services/cli/strategy_table.hpp"
#include "services/cli/task_options.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services::cli {
namespace {

struct Options {
  std::string cell;
  std::vector<double> from;
  int tasks = 600;
  std::uint64_t seed = 1;
  planner::SimplexOptions simplex;
};

ExitCode run(const Settings& settings, const Options& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  const auto began = std::chrono::steady_clock::now();
  StrategyResults results;
  planner::SimplexResult found;
  try {
    const planner::StrategyProblem problem(file.cell);
    const planner::SystemStrategy initial = strategy_from(options.from, file, problem);
    planner::TaskSet tasks = problem.draw(options.seed, options.tasks);
    problem.look_at_ways(tasks);
    found = refine_by_simplex(problem, tasks, initial, options.simplex);
    results = strategy_results(problem, {{initial, found.initial}, {found.strategy, found.final}});
  } catch (const planner::ProblemError& error) {
    throw Failure(ExitCode::kBadInput, file.path + ": " + error.what());
  }
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
  const Json both = strategy_json(results, 2);
  const Json value = {{"cell", file.cell.name},     {"seed", options.seed},
                      {"initial", both[0]},         {"optimum", both[1]},
                      {"evaluations", found.steps}, {"tolerance_steps", options.simplex.tolerance}};
  print(settings, value,
        strategy_table(results, 2, Palette::for_stream(stdout)) + "\n1: where it began; 2: the best of " +
            std::to_string(found.steps) + " evaluations\n");
  std::fprintf(stderr, "%s\n", duration_text(spent.count()).c_str());
  return results.rows.back().faults == 0 ? ExitCode::kDone : ExitCode::kNegative;
}

}  // namespace

void add_strategy_simplex(CLI::App& parent, Session& session) {
  CLI::App* command = parent.add_subcommand(
      "simplex", "Improves one strategy locally by the simplex method of Nelder and Mead; directions stay");
  auto options = std::make_shared<Options>();
  command->add_option("CELL", options->cell, "cell file (YAML) with tasks.areas")->required();
  add_from(*command, options->from,
           "coefficients and direction of each arm, one after the other: \"0 -2.5 1 2 -2.5 1\" (the cell file's)");
  add_whole_number(
      *command, "--tasks", [options](std::uint64_t n) { options->tasks = static_cast<int>(n); },
      "tasks of each arm, the same in every evaluation (600)", 1, 1'000'000);
  add_whole_number(
      *command, "--steps", [options](std::uint64_t n) { options->simplex.most_steps = static_cast<int>(n); },
      "evaluations at most (200)", 1, 1'000'000);
  constexpr config::Bounds kTolerance{0.0, 1e6, "steps", true};
  add_number(
      *command, "--tolerance", [options](double x) { options->simplex.tolerance = x; },
      "ends where T(L) differs by less within the simplex (0.5)", kTolerance);
  add_seed(*command, options->seed, "of the tasks (1)");
  command->footer("Exit code 1 when the best strategy had a fault.");
  command->callback(
      [&session, options] { session.action = [&session, options] { return run(session.settings, *options); }; });
}

}  // namespace hecaton::services::cli
