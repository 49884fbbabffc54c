/// hecaton-strategies search, hecaton-strategies show: the off-line stage of motion strategies [Mediavilla02].

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "planner/strategy_search/motion_problem.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"
#include "services/strategies/commands.hpp"
#include "services/strategies/results.hpp"
#include "services/strategies/search_execution.hpp"

namespace hecaton::services::cli {
namespace {

struct SearchOptions {
  std::string cell;
  std::string results;  ///< file names without ending; empty: none
  std::vector<double> alpha;
  std::vector<double> beta;
  std::string combine;  ///< CSV of pairs; empty: the grid
  std::string basis = "second";
  std::string neighbours = "listed";
  planner::SearchPlan plan;
  int threads = 0;  ///< 0: one per processor
  std::size_t top = 10;
  bool resume = false;
};

/// Throws Failure if the file cannot be written. With std::ios::app and an empty text, only checks this.
void write_file(const std::string& path, const std::string& text, std::ios::openmode mode = std::ios::trunc) {
  std::ofstream file(path, mode);
  file << text;
  file.close();
  if (!file) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be written");
}

Json stages_json(const planner::SearchReport& report) {
  Json stages = Json::array();
  for (const planner::SearchReport::Stage& stage : report.stages) {
    stages.push_back({{"name", stage.round.name},
                      {"tasks", stage.round.tasks},
                      {"seed", stage.round.seed},
                      {"candidates", stage.candidates},
                      {"evaluated", stage.evaluated},
                      {"without_fault", stage.without_fault},
                      {"arm_ticks", stage.arm_ticks}});
  }
  return stages;
}

/// Rejects repeated values: a strategy would count twice.
void reject_repeated(const char* option, const std::vector<double>& values) {
  for (auto value = values.begin(); value != values.end(); ++value) {
    if (std::find(values.begin(), value, *value) == value) continue;
    throw Failure(ExitCode::kBadInput,
                  std::string(option) + " has " + config::number_text(*value + 0.0) + " twice: its values must differ");
  }
}

/// Input of the search; each rank reads it, and all must be equal.
struct Task {
  std::string cell;
  std::unique_ptr<planner::StrategyProblem> problem;
  std::vector<planner::SystemStrategy> candidates;
  std::string title;
};

Task read_task(const SearchOptions& options, bool print_notes) {
  reject_repeated("--alpha", options.alpha);
  reject_repeated("--beta", options.beta);
  const config::CellFile file = config::load_cell_file(options.cell);
  planner::StrategyGrid grid;
  if (!options.alpha.empty()) grid.alpha = options.alpha;
  if (!options.beta.empty()) grid.beta = options.beta;
  try {
    Task task{file.cell.name, std::make_unique<planner::StrategyProblem>(file.cell), {}, {}};
    for (const std::string& note : task.problem->notes()) {
      if (print_notes) std::fprintf(stderr, "hecaton-strategies: %s\n", note.c_str());
    }
    planner::FlatProblem& flat = task.problem->flat();
    flat.nearest_first = options.neighbours == "nearest";
    flat.basis = options.basis == "last" ? 1 : options.basis == "first" ? 2 : 0;
    task.candidates = options.combine.empty() ? grid.of(*task.problem) : combine_pairs(options.combine, *task.problem);
    task.title = search_title(*task.problem, options.plan, task.candidates);
    return task;
  } catch (const planner::ProblemError& error) {
    throw Failure(ExitCode::kBadInput, file.path + ": " + error.what());
  }
}

void print_summary(const planner::SearchReport& report, double seconds, const Ranks& ranks, int threads) {
  std::uint64_t ticks = 0;
  for (const planner::SearchReport::Stage& stage : report.stages) {
    std::fprintf(stderr, "%s: %zu of %zu strategies without fault in %d tasks of each arm (seed %llu)\n",
                 stage.round.name.c_str(), stage.without_fault, stage.evaluated, stage.round.tasks,
                 static_cast<unsigned long long>(stage.round.seed));
    ticks += stage.arm_ticks;
  }
  const std::string processes = ranks.count() > 1 ? std::to_string(ranks.count()) + " processes with " : "";
  std::fprintf(stderr, "%.1f million arm ticks in %s by %s%d thread%s\n", 1e-6 * static_cast<double>(ticks),
               duration_text(seconds).c_str(), processes.c_str(), threads, threads == 1 ? "" : "s");
}

ExitCode search(const Settings& settings, const SearchOptions& options) {
  Ranks ranks;
  const bool writes = ranks.first() && !options.results.empty();
  const std::string progress_path = options.results + ".progress";
  Task task;
  StrategyProgress progress(!ranks.alone());
  std::string evaluations;
  ranks.together([&] { task = read_task(options, ranks.first()); });
  ranks.require_same(task.title);
  ranks.together([&] {
    if (writes && options.resume) evaluations = read_progress(progress_path, task.title);
    if (writes) write_file(options.results + ".csv", "", std::ios::app);
    if (writes) progress.write_to(progress_path, task.title);
  });
  progress.reuse(ranks.broadcast(evaluations));

  planner::SearchHooks hooks;
  hooks.threads = options.threads > 0 ? options.threads : ranks.threads();
  progress.hook(hooks);
  // mpirun ends all its processes at a signal; the progress file keeps what they have done.
  std::optional<Interruption> interruption;
  if (ranks.alone()) interruption.emplace();
  if (interruption) hooks.ended = [&interruption] { return interruption->requested(); };
  ranks.divide(hooks);
  const auto began = std::chrono::steady_clock::now();
  planner::SearchReport report;
  ranks.together([&] {
    try {
      report = planner::search_strategies(*task.problem, task.candidates, options.plan, hooks);
    } catch (const planner::ProblemError& error) {
      throw Failure(ExitCode::kBadInput, options.cell + ": " + error.what());
    }
  });
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
  if (!ranks.first()) return ExitCode::kDone;
  progress.end();

  const StrategyResults results = strategy_results(*task.problem, report.best);
  std::optional<Interrupted> interrupted;
  if (report.ended_early) {
    const planner::SearchReport::Stage& last = report.stages.back();
    const bool in_refinement = last.evaluated == last.candidates;
    interrupted = in_refinement
                      ? interruption->after(0, options.plan.refine, "refinements")
                      : interruption->after(last.evaluated, last.candidates, "strategies in round " + last.round.name);
  }
  if (writes && !interrupted) {
    write_file(options.results + ".csv", strategy_csv(results));
    write_file(options.results + ".yaml", strategy_yaml(results, task.cell));
  }
  const Json value = {{"cell", task.cell},
                      {"seed", options.plan.seed},
                      {"stages", stages_json(report)},
                      {"strategies", strategy_json(results, options.top)},
                      {"interrupted", to_json(interrupted)}};
  // Under mpirun, stdout is a terminal, whatever mpirun connects it to.
  const Palette palette = ranks.alone() ? Palette::for_stream(stdout) : Palette(false);
  print(settings, value,
        strategy_table(results, options.top, palette) + (interrupted ? "\n" + interrupted->text() + "\n" : ""));
  print_summary(report, spent.count(), ranks, hooks.threads);
  if (interrupted) {
    std::fprintf(stderr, "%s; %s\n", interrupted->text().c_str(),
                 writes ? "the same command with --resume continues" : "with --results a search can be resumed");
    return interrupted->exit_code();
  }
  const bool found = !results.rows.empty() && results.rows.front().faults == 0;
  return found ? ExitCode::kDone : ExitCode::kNegative;
}

void add_threads(CLI::App& app, int& threads) {
  add_whole_number(
      app, "--threads", [&threads](std::uint64_t n) { threads = static_cast<int>(n); },
      "number of threads; does not change results (one per processor; under mpirun divided among the processes of the "
      "machine)",
      1, 1024);
}

}  // namespace

void add_search(CLI::App& parent, Session& session) {
  CLI::App* command = parent.add_subcommand(
      "search", "Searches strategies for a cell's motion problem: evaluates a grid, then confirms the best");
  auto options = std::make_shared<SearchOptions>();
  planner::SearchPlan& plan = options->plan;
  command->add_option("CELL", options->cell, "cell file (YAML) with tasks.areas")->required();
  add_whole_number(
      *command, "--tasks", [&plan](std::uint64_t n) { plan.screening_tasks = static_cast<int>(n); },
      "tasks of each arm for each strategy of the grid, up to its first fault (300)", 1, 1'000'000);
  add_whole_number(
      *command, "--confirm", [&plan](std::uint64_t n) { plan.confirm_tasks = static_cast<int>(n); },
      "tasks of each arm and set to confirm a strategy without fault (1800)", 1, 1'000'000);
  add_whole_number(
      *command, "--sets", [&plan](std::uint64_t n) { plan.confirm_sets = static_cast<int>(n); },
      "sets of new tasks for the confirmation, each with its own seed (2)", 0, 100);
  add_seed(*command, plan.seed, "of the first set of tasks; the next sets use the next seeds (1)");
  command->add_flag("--complete", plan.complete,
                    "simulate all tasks of all strategies, also after faults, and keep all; for `plot`");
  command->add_flag("--halving", plan.halving,
                    "successive halving: short rounds first, each keeping the best third; for large grids");
  add_whole_number(
      *command, "--refine", [&plan](std::uint64_t n) { plan.refine = static_cast<int>(n); },
      "number of best strategies to refine by the simplex method before the confirmation (0)", 0, 1000);
  add_numbers(*command, "--alpha", options->alpha, 0, "the grid's values of each arm's first coefficient (-2 0 2)",
              kCoefficient);
  add_numbers(*command, "--beta", options->beta, 0,
              "the grid's values of each arm's further coefficients (-2.5 -1 1 2.5)", kCoefficient);
  command
      ->add_option("--combine", options->combine,
                   "instead of a grid: combinations whose neighbours had no fault in these results (CSV) of a cell "
                   "with two such arms")
      ->type_name("FILE")
      ->excludes("--alpha")
      ->excludes("--beta");
  add_choice(*command, "--basis", options->basis, {"second", "last", "first"},
             "for comparison: first axis of the null space's basis; cells only support `second`");
  add_choice(
      *command, "--neighbours", options->neighbours, {"listed", "nearest"},
      "for comparison: order of neighbours, of the paper or nearest to the goal first; cells only support `listed`");
  add_threads(*command, options->threads);
  add_whole_number(
      *command, "--top", [options](std::uint64_t n) { options->top = n; }, "number of best strategies to show (10)", 1,
      100000);
  command
      ->add_option("--results", options->results,
                   "write the confirmed strategies to NAME.csv, the best one to NAME.yaml for `strategy: {file: …}`, "
                   "the progress to NAME.progress")
      ->type_name("NAME");
  for (const char* comparison : {"--basis", "--neighbours"}) command->get_option(comparison)->excludes("--results");
  command->add_flag("--resume", options->resume, "resume an interrupted search; needs --results")->needs("--results");
  command->footer(
      "Exit code 1 if all strategies had a fault. After Ctrl-C no results are written; --resume continues from "
      "NAME.progress. `mpirun hecaton-strategies search …` divides the work among its processes, also on several "
      "machines: each reads the same cell file, and rank 0 writes the results. Their number does not change results.");
  command->callback(
      [&session, options] { session.action = [&session, options] { return search(session.settings, *options); }; });
}

namespace {

struct ShowOptions {
  std::string file;
  std::size_t top = 20;
};

}  // namespace

void add_show(CLI::App& parent, Session& session) {
  CLI::App* command = parent.add_subcommand("show", "Shows the results of a search");
  auto options = std::make_shared<ShowOptions>();
  command->add_option("FILE", options->file, "results (CSV) of a search")->required();
  add_whole_number(
      *command, "--top", [options](std::uint64_t n) { options->top = n; }, "number of best strategies to show (20)", 1,
      100000);
  command->callback([&session, options] {
    session.action = [&session, options] {
      const StrategyResults results = read_strategy_csv(options->file);
      print(session.settings, strategy_json(results, options->top),
            strategy_table(results, options->top, Palette::for_stream(stdout)));
      return ExitCode::kDone;
    };
  });
}

}  // namespace hecaton::services::cli
