/// hecaton simulate: many tasks of a cell in virtual time, without network.

#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>

#include <CLI/CLI.hpp>

#include "planner/simulation/batch.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/episode_plotter.hpp"
#include "services/cli/report.hpp"
#include "services/cli/task_options.hpp"
#include "services/command_line/choice_option.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

struct Options {
  std::string cell;
  std::string method;
  int rollouts = -1;  ///< −1: as the cell file says
  bool no_routes = false;
  std::string report;
  std::string plot;    ///< folder for pictures; empty: none
  double speed = 0.0;  ///< [rad/s]; 0: the cell's limits
  planner::BatchOptions batch;
};

/// The same limit for every joint that turns, whatever cell file and URDF say.
void limit_speed(planner::Cell& cell, double speed) {
  for (planner::PlannedArm& planned : cell.arms) {
    for (const planner::Link& link : planned.arm.model->links) {
      if (link.joint >= 0 && link.joint_type != planner::JointType::kPrismatic) {
        planned.arm.limits.velocity[link.joint] = speed;
      }
    }
  }
}

/// Or nobody would know why hardly anything is reached.
void warn_of_old_news(const planner::Cell& cell, const planner::NetworkParameters& network) {
  const double oldest = network.age + network.jitter;
  for (const planner::PlannedArm& planned : cell.arms) {
    if (oldest <= planned.parameters.state_age_limit) continue;
    std::fprintf(
        stderr,
        "hecaton: news are up to %s old, and arm %s stands where they are older than its state_age_limit = %s\n",
        duration_text(oldest).c_str(), planned.arm.name.c_str(),
        duration_text(planned.parameters.state_age_limit).c_str());
    return;
  }
}

Report make_report(const planner::Cell& cell, const Options& options, planner::BatchReport batch) {
  Report report;
  report.cell = cell.name;
  report.method = options.method.empty() ? "as configured" : options.method;
  report.seed = options.batch.seed;
  report.tasks = batch.tasks;
  report.reached = batch.reached;
  report.blocked = batch.blocked;
  report.timed_out = batch.timed_out;
  report.not_drawn = options.batch.tasks - batch.tasks;
  report.contacts = batch.contacts;
  if (batch.judged) report.smallest = batch.smallest;
  report.duration = batch.duration;
  const bool measured = options.batch.measure_ticks;
  report.tick_us = quantiles(std::move(batch.clocked.tick_us));
  report.rollouts = RolloutReport{batch.rollouts, batch.rollout_ticks,
                                  measured ? std::optional(batch.clocked.rollout_us) : std::nullopt};
  report.times = std::move(batch.times);
  for (const planner::ArmTally& arm : batch.arms) {
    report.arms.push_back({arm.name, arm.tasks, arm.reached, arm.blocked, arm.timed_out});
  }
  const planner::NetworkParameters& network = options.batch.network;
  report.extra["network"] = {
      {"age_s", network.age}, {"jitter_s", network.jitter}, {"loss", network.loss}, {"burst", network.burst}};
  report.extra["ticks"] = batch.ticks;
  report.extra["relaxed_ticks"] = batch.relaxed_ticks;
  report.extra["subspaces_drawn"] = batch.redraws;
  report.extra["yielding_ticks"] = batch.yielding_ticks;
  report.extra["routes"] = batch.routes;
  report.extra["coupled_plans"] = batch.coupled_plans;
  const planner::Chatter& chatter = batch.chatter;
  report.chatter = ChatterReport{chatter.turns_per_second(), chatter.quick_per_second(), chatter.joint_time};
  return report;
}

ExitCode run(const Settings& settings, const Options& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  require_tasks(file);
  planner::Cell cell = file.cell;
  check_writable(options.report);
  for (planner::PlannedArm& planned : cell.arms) {
    if (options.rollouts >= 0) planned.parameters.rollout.candidates = options.rollouts;
    if (options.no_routes) planned.parameters.route = {0.0, 0.0};
  }
  if (!options.method.empty()) {
    for (planner::PlannedArm& planned : cell.arms) {
      planned.select_method(options.method);
      if (const auto objection = planned.objection()) throw Failure(ExitCode::kBadInput, "--method = " + *objection);
    }
  }
  if (options.speed > 0.0) limit_speed(cell, options.speed);
  warn_of_old_news(cell, options.batch.network);
  const auto began = std::chrono::steady_clock::now();
  planner::BatchOptions batch_options = options.batch;
  std::optional<EpisodePlotter> plotter;
  if (!options.plot.empty()) {
    plotter.emplace(options.plot, cell);
    batch_options.observe_first = [&plotter](const planner::EpisodeMoment& moment) { plotter->draw(moment); };
  }
  planner::BatchReport batch = planner::simulate_tasks(cell, batch_options);
  if (plotter && plotter->failure()) throw Failure(ExitCode::kBadInput, *plotter->failure());
  if (plotter) std::fprintf(stderr, "%d pictures in %s\n", plotter->pictures(), options.plot.c_str());
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
  if (batch.tasks == 0) throw Failure(ExitCode::kBadInput, file.path + ": tasks: " + batch.failure);
  if (!batch.failure.empty()) std::fprintf(stderr, "hecaton: %s\n", batch.failure.c_str());

  const double running = 1e-6 * batch.clocked.run_us;
  const Report report = make_report(cell, options, std::move(batch));
  print(settings, to_json(report), table_text(report, Palette::for_stream(stdout)));
  if (!options.report.empty()) write_report(options.report, report);
  std::fprintf(stderr, "%s simulated in %s: %.1f simulated seconds per second\n",
               duration_text(report.duration).c_str(), duration_text(spent.count()).c_str(),
               report.duration / spent.count());
  if (running > 0.0) {
    std::fprintf(stderr, "without drawing tasks and setting up: %.1f simulated seconds per second of an episode\n",
                 report.duration / running);
  }
  return report.positive() ? ExitCode::kDone : ExitCode::kNegative;
}

}  // namespace

void add_simulate(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand(
      "simulate", "Gives the arms of a cell random conflicting tasks in virtual time, without network, and reports");
  auto options = std::make_shared<Options>();
  planner::BatchOptions& batch = options->batch;
  command->add_option("CELL", options->cell, "cell file (YAML)")->required();
  add_whole_number(
      *command, "--tasks", [&batch](std::uint64_t n) { batch.tasks = static_cast<int>(n); },
      "goals for single arms, in total (100)", 1, kMostTasks);
  add_seed(*command, batch.seed, "of all random choices: the same seed gives the same report, to the last bit (1)");
  const std::vector<std::string_view> methods = planner::built_in_methods().names();
  add_choice(*command, "--method", options->method, {methods.begin(), methods.end()},
             "what decides each tick, for all arms, instead of the cell file's");
  add_whole_number(
      *command, "--rollouts", [options](std::uint64_t n) { options->rollouts = static_cast<int>(n); },
      "manoeuvres that an arm plays through at a time when it is held back, instead of the cell file's; 0: none", 0,
      1000);
  command->add_flag("--no-routes", options->no_routes,
                    "arms that do not come nearer plan neither routes around what stands in their way nor for each "
                    "other, whatever the cell "
                    "file says");
  add_duration(*command, "--age", batch.network.age,
               "mean age of the states that arms see of each other and of obstacles, up to 10s (0ms)", 0.0, 10.0);
  add_duration(*command, "--jitter", batch.network.jitter, "ages are uniform within age ± jitter, at most age (0ms)",
               0.0, 10.0);
  constexpr config::Bounds kLoss{0.0, 0.999999, ""};
  add_number(
      *command, "--loss", [&batch](double loss) { batch.network.loss = loss; },
      "probability that a state is lost, below 1 (0)", kLoss);
  constexpr config::Bounds kBurst{1.0, 1e6, "states"};
  add_number(
      *command, "--burst", [&batch](double burst) { batch.network.burst = burst; },
      "mean number of states lost in a row (losses are independent)", kBurst);
  constexpr config::Bounds kSpeed{0.0, 100.0, "rad/s", true};
  add_number(
      *command, "--speed", [options](double speed) { options->speed = speed; },
      "speed limit of every joint that turns, up to 100 rad/s, instead of the cell's and the URDF's", kSpeed);
  add_whole_number(
      *command, "--threads", [&batch](std::uint64_t n) { batch.threads = static_cast<int>(n); },
      "that simulate episodes at the same time or, when there are fewer of those, share the arms of one (ten at least "
      "each); the report does not depend on it (1)",
      1, 1024);
  command->add_option("--report", options->report, "also write the report to this file, as JSON")->type_name("FILE");
  command
      ->add_option("--plot", options->plot,
                   "draw the first task's arms into this folder, as SVG: in workspace and C-space if they plan "
                   "through C-space, in workspace and field if by potentials")
      ->type_name("DIR");
  command->add_flag("--timing", batch.measure_ticks,
                    "measure ticks on the machine's clock and the processor time of rollouts: fills tick_us and "
                    "rollouts.us, which are null "
                    "otherwise, and which no seed makes repeatable");
  command->footer(
      "Exit code 1 when a task was missed or could not be drawn, or a contact was seen; 3 when none could be drawn in "
      "the first 50 episodes (of one task for every arm) or in all of them. Figures of the machine's clock go to "
      "stderr, "
      "so that the report is the same on every run.");
  command->callback([&session, options] {
    if (options->batch.network.jitter > options->batch.network.age) {
      throw Failure(ExitCode::kBadInput, "--jitter = " + duration_text(options->batch.network.jitter) +
                                             " must be at most --age = " + duration_text(options->batch.network.age));
    }
    const double loss = options->batch.network.loss;
    const double burst = options->batch.network.burst;
    if (burst > 0.0 && !(loss > 0.0)) {
      throw Failure(ExitCode::kBadInput, "--burst = " + config::number_text(burst) + " needs a --loss above 0");
    }
    if (burst > 0.0 && burst < loss / (1.0 - loss)) {
      throw Failure(ExitCode::kBadInput,
                    "--burst = " + config::number_text(burst) + " must be at least loss/(1 − loss) = " +
                        config::number_text(loss / (1.0 - loss)) + " for --loss = " + config::number_text(loss));
    }
    session.action = [&session, options] { return run(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
