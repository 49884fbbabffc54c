/// hecaton simulate: many tasks of a cell in virtual time, without network.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>

#include <CLI/CLI.hpp>

#include "planner/simulation/batch.hpp"
#include "services/arm_driver/device_choice.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/episode_recorder.hpp"
#include "services/cli/plots.hpp"
#include "services/cli/task_report.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"
#include "services/simulation_recording/simulation_recording.hpp"
#include "services/tick_log/cell_changes.hpp"

namespace hecaton::services::cli {
namespace {

constexpr std::string_view kPerfect = "perfect";

struct SimulateOptions {
  std::string cell;
  std::string report;
  std::string plot;            ///< folder; empty: no plots
  std::string record;          ///< file; empty: no record
  std::string servo;           ///< preset of all arms; empty: as the cell file says
  std::optional<int> episode;  ///< from 0; empty: as many as there are tasks
  CellChanges changes;
  planner::BatchOptions batch;
};

/// Of each arm. Empty: all are perfect.
std::vector<planner::ServoParameters> servos_of(const config::CellFile& file, const std::string& preset) {
  std::vector<planner::ServoParameters> servos = simulated_servos(file);
  for (const planner::ServoPreset& known : planner::servo_presets()) {
    if (known.name == preset) servos.assign(servos.size(), known.servo);
  }
  if (preset == kPerfect) servos.assign(servos.size(), {});
  const bool perfect = std::all_of(servos.begin(), servos.end(), [](const auto& servo) { return servo.perfect(); });
  return perfect ? std::vector<planner::ServoParameters>() : servos;
}

using Findings = std::vector<config::Finding>;

/// Also on stderr.
void warn(Findings& findings, std::string sentence) {
  std::fprintf(stderr, "hecaton: %s\n", config::sentence_text(sentence).c_str());
  findings.push_back({config::Severity::kWarning, std::move(sentence)});
}

/// With such states most tasks are missed, and the counts alone do not show why.
void warn_of_stale_states(const planner::Cell& cell, const planner::NetworkParameters& network, Findings& findings) {
  const double oldest = network.age + network.jitter;
  for (const planner::PlannedArm& planned : cell.arms) {
    if (oldest <= planned.parameters.state_age_limit) continue;
    warn(findings,
         "states are up to " + duration_text(oldest) + " old; arm " + planned.arm.name +
             " stops at states older than its state_age_limit = " + duration_text(planned.parameters.state_age_limit));
    return;
  }
}

/// Shows the progress of a batch, and ends the batch after a signal.
class BatchWatch {
 public:
  BatchWatch(const planner::Cell& cell, planner::BatchOptions& batch)
      : asked_(batch.tasks), period_(cell.timing.control_period) {
    batch.progress = [this](int done) { done_ = done; };
    batch.ended = [this] {
      constexpr int kShownEvery = 64;  // periods
      if (++periods_ % kShownEvery == 0) show();
      return interruption_.requested();
    };
  }
  [[nodiscard]] std::optional<Interrupted> interrupted(const planner::BatchReport& report) const {
    if (!report.ended_early) return std::nullopt;
    return interruption_.after(report.tasks + report.not_drawn, asked_, "tasks");
  }
  void end() { progress_.clear(); }

 private:
  void show() {
    progress_.show("simulate", done_, asked_, "tasks",
                   duration_text(static_cast<double>(periods_.load()) * period_) + " simulated");
  }

  int asked_;
  double period_;  ///< [s]
  std::atomic<int> done_ = 0;
  std::atomic<std::int64_t> periods_ = 0;
  Interruption interruption_;
  Progress progress_;
};

std::vector<MissedTask> missed_of(const planner::Cell& cell, const std::vector<planner::MissedTask>& missed) {
  std::vector<MissedTask> list;
  for (const planner::MissedTask& task : missed) {
    list.push_back({task.episode + 1,
                    cell.arms[task.arm].arm.name,
                    task.outcome == planner::TaskOutcome::kTimedOut ? "timed_out" : "blocked",
                    {task.goal.begin(), task.goal.end()},
                    task.reason});
  }
  return list;
}

/// `asked`: number of tasks.
Report make_report(const planner::Cell& cell, const SimulateOptions& options, int asked, planner::BatchReport batch) {
  Report report;
  report.cell = cell.name;
  report.method = options.changes.method.empty() ? "as configured" : options.changes.method;
  report.seed = options.batch.seed;
  report.tasks = batch.tasks;
  report.reached = batch.reached;
  report.blocked = batch.blocked;
  report.timed_out = batch.timed_out;
  report.asked = asked;
  report.not_drawn = batch.not_drawn;
  report.missed = missed_of(cell, batch.missed);
  report.contacts = batch.contacts;
  if (batch.has_smallest) report.smallest = batch.smallest;
  report.duration = batch.duration;
  const bool measured = options.batch.measure_ticks;
  report.tick_us = quantiles(std::move(batch.computing.tick_us));
  report.rollouts = RolloutReport{batch.rollouts, batch.rollout_ticks,
                                  measured ? std::optional(batch.computing.rollout_us) : std::nullopt};
  report.times = std::move(batch.reach_times);
  for (const planner::ArmTally& arm : batch.arms) {
    report.arms.push_back({arm.name, arm.tasks, arm.reached, arm.blocked, arm.timed_out});
  }
  const planner::NetworkParameters& network = options.batch.network;
  report.extra["network"] = {
      {"age_s", network.age}, {"jitter_s", network.jitter}, {"loss", network.loss}, {"burst", network.burst}};
  report.extra["servo"] = options.servo.empty() ? "as configured" : options.servo;
  report.extra["ticks"] = batch.ticks;
  report.extra["relaxed_ticks"] = batch.relaxed_ticks;
  report.extra["subspaces_drawn"] = batch.subspaces_drawn;
  report.extra["yielding_ticks"] = batch.yielding_ticks;
  report.extra["routes"] = batch.routes;
  report.extra["coupled_plans"] = batch.coupled_plans;
  const planner::VelocityReversals& reversals = batch.reversals;
  report.reversals = ReversalReport{reversals.per_second(), reversals.quick_per_second(), reversals.joint_time};
  return report;
}

void begin_recording(std::optional<SimulationRecording>& recording, const SimulateOptions& options,
                     const config::CellFile& file) {
  try {
    recording.emplace(options.record, file, options.changes);
  } catch (const recorder::RecordingError& error) {
    throw Failure(ExitCode::kBadInput, std::string("--record: ") + error.what());
  }
}

void finish_recording(SimulationRecording& recording, const std::string& path) {
  try {
    recording.finish();
  } catch (const recorder::RecordingError& error) {
    throw Failure(ExitCode::kBadInput, std::string("--record: ") + error.what());
  }
  std::fprintf(stderr, "%llu messages, %llu of them ticks of planners, in %s\n",
               static_cast<unsigned long long>(recording.messages()),
               static_cast<unsigned long long>(recording.ticks()), config::valid_utf8(path).c_str());
}

ExitCode run_simulate(const Settings& settings, const SimulateOptions& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  require_tasks(file);
  planner::Cell cell = file.cell;
  check_writable(options.report);
  if (const auto objection = options.changes.apply(cell)) {
    throw Failure(ExitCode::kBadInput, "--method = " + *objection);
  }
  Findings findings;
  warn_of_stale_states(cell, options.batch.network, findings);
  const auto began = std::chrono::steady_clock::now();
  planner::BatchOptions batch_options = options.batch;
  if (options.episode) {
    batch_options.first_episode = *options.episode;
    batch_options.tasks = static_cast<int>(cell.arms.size());
  }
  batch_options.servos = servos_of(file, options.servo);
  std::optional<EpisodePlotter> plotter;
  std::optional<EpisodeRecorder> recorder;
  if (!options.plot.empty()) plotter.emplace(options.plot, cell);
  std::optional<SimulationRecording> recording;
  const bool records_all = options.record.ends_with(".mcap");
  if (records_all) begin_recording(recording, options, file);
  if (!options.record.empty() && !records_all) recorder.emplace(options.record);
  if (plotter || recorder) {
    batch_options.observe_first = [&plotter, &recorder](const planner::EpisodeMoment& moment) {
      if (plotter) plotter->plot(moment);
      if (recorder) recorder->record(moment);
    };
  }
  BatchWatch watch(cell, batch_options);
  if (recording) {
    batch_options.log = &*recording;
    batch_options.ended = [&recording, ended = batch_options.ended] { return ended() || recording->failed(); };
  }
  planner::BatchReport batch = planner::simulate_tasks(cell, batch_options);
  watch.end();
  if (plotter && plotter->failure()) throw Failure(ExitCode::kBadInput, *plotter->failure());
  if (plotter) std::fprintf(stderr, "%d plots in %s\n", plotter->plots(), config::valid_utf8(options.plot).c_str());
  if (recorder) recorder->finish();
  if (recording) finish_recording(*recording, options.record);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
  if (batch.tasks == 0 && !batch.ended_early) {
    throw Failure(ExitCode::kBadInput, file.path + ": tasks: " + batch.failure.value_or("none was asked for"));
  }
  if (batch.failure) warn(findings, *batch.failure);
  const std::optional<Interrupted> interrupted = watch.interrupted(batch);

  const double running = 1e-6 * batch.computing.run_us;
  Report report = make_report(cell, options, batch_options.tasks, std::move(batch));
  report.findings = std::move(findings);
  report.interrupted = interrupted;
  print(settings, to_json(report), table_text(report, Palette::for_stream(stdout)));
  if (!options.report.empty()) write_report(options.report, report);
  std::fprintf(stderr, "%s simulated in %s: %.1f simulated seconds per second\n",
               duration_text(report.duration).c_str(), duration_text(spent.count()).c_str(),
               report.duration / spent.count());
  if (running > 0.0) {
    std::fprintf(stderr, "episodes alone, without setup and the search for tasks: %.1f simulated seconds per second\n",
                 report.duration / running);
  }
  return report.exit_code();
}

}  // namespace

void add_simulate(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand(
      "simulate", "Simulates random conflicting tasks of a cell in virtual time, without network, and prints a report");
  auto options = std::make_shared<SimulateOptions>();
  planner::BatchOptions& batch = options->batch;
  command->add_option("CELL", options->cell, "cell file (YAML)")->required();
  add_whole_number(
      *command, "--tasks", [&batch](std::uint64_t n) { batch.tasks = static_cast<int>(n); },
      "goals for single arms, in total (100)", 1, kMostTasks);
  add_seed(*command, batch.seed, "of all random choices: the same seed gives the same report, bit by bit (1)");
  add_whole_number(
      *command, "--episode", [options](std::uint64_t n) { options->episode = static_cast<int>(n - 1); },
      "this episode alone, such as the `round` of a missed task in a report (all)", 1, kMostTasks)
      ->excludes(command->get_option("--tasks"));
  const std::vector<std::string_view> methods = planner::built_in_methods().names();
  add_choice(*command, "--method", options->changes.method, {methods.begin(), methods.end()},
             "motion method of all arms (of the cell file)");
  add_whole_number(
      *command, "--rollouts", [options](std::uint64_t n) { options->changes.rollouts = static_cast<int>(n); },
      "rollouts that a blocked arm runs at a time; 0: none (of the cell file)", 0, 1000);
  command->add_flag("--no-routes", options->changes.no_routes,
                    "stalled arms plan no routes around obstacles and no coupled plans");
  add_duration(*command, "--age", batch.network.age,
               "mean age of the received states of other arms and obstacles, up to 10s (0ms)", 0.0, 10.0);
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
  std::vector<std::string> servos{std::string(kPerfect)};
  for (const planner::ServoPreset& preset : planner::servo_presets()) servos.emplace_back(preset.name);
  add_choice(*command, "--servo", options->servo, std::move(servos),
             "how all arms follow their set-points: as the controllers of this kind (of the cell file: "
             "device.servo)");
  constexpr config::Bounds kSpeed{0.0, 100.0, "rad/s", true};
  add_number(
      *command, "--speed", [options](double speed) { options->changes.speed = speed; },
      "speed limit of all revolute joints, up to 100 rad/s (of the cell file and the URDF)", kSpeed);
  add_whole_number(
      *command, "--threads", [&batch](std::uint64_t n) { batch.threads = static_cast<int>(n); },
      "threads for episodes or, with fewer episodes, for the arms of one (at least ten each); the report does not "
      "depend on it (1)",
      1, 1024);
  command->add_option("--report", options->report, "also write the report to this file, as JSON")->type_name("FILE");
  command
      ->add_option(
          "--plot", options->plot,
          "plot the first episode into this folder, as SVG: workspace, and C-space or field of methods that have one")
      ->type_name("DIR");
  command
      ->add_option(
          "--record", options->record,
          "FILE.mcap: record all episodes as `record` does a running cell, for `replay`, `render`, `explain` and "
          "`bag`; another file: the first episode, a line of JSON each 50 ms")
      ->type_name("FILE");
  command->add_flag("--timing", batch.measure_ticks,
                    "measure ticks and rollouts: fills tick_us and rollouts.us, which differ between runs");
  command->footer(
      "Exit code 1 when a task was missed or had no free goals, or there was a contact; 3 when the first 50 episodes "
      "(of one task per arm), or all of them, had no free goals. Measured durations go to stderr, so that the report "
      "is the same in every run.");
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
    session.action = [&session, options] { return run_simulate(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
