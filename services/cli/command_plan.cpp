/// hecaton plan: plans one path from a start to a goal, without network.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include <CLI/CLI.hpp>

#include "planner/global/global_planner.hpp"
#include "planner/global/plan.hpp"
#include "planner/global/timed_path.hpp"
#include "planner/methods/registry.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/plan.hpp"
#include "services/cli/plots.hpp"
#include "services/cli/task_report.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"
#include "services/config/validate.hpp"

namespace hecaton::services::cli {
namespace {

namespace global = planner::global;
using Clock = std::chrono::steady_clock;

using Path = planner::MethodTraits::Path;

/// How the motion method of that name plans paths; kNone for a global planner.
Path motion_path(const std::string& name) {
  for (const planner::MethodTraits& traits : planner::built_in_methods().traits()) {
    if (traits.name == name) return traits.path;
  }
  return Path::kNone;
}

struct PlanOptions {
  PlanArguments arguments;
  std::string method{global::default_planner()->traits().name};
  std::uint64_t seed = 1;
  double budget = 10.0;    ///< [s]
  double step = 0.03;      ///< [rad | m]
  double clearance = 0.0;  ///< [m]
  bool simplify = true;
  double keep = 0.01;       ///< clearance that shortening keeps where the found path has it [m]
  double deviation = 0.05;  ///< of rounded corners from the path [rad | m]
  double period = 0.0;      ///< of the trajectory's samples [s]; 0: none
  double jerk = 0.0;        ///< limit of every joint [rad/s³ | m/s³]; 0: none
  std::string plot;         ///< file, or folder for a simulated plan; empty: no plot
};

double microseconds_since(Clock::time_point began) {
  return std::chrono::duration<double, std::micro>(Clock::now() - began).count();
}

std::string effort_of(const global::Plan& plan) {
  return std::to_string(plan.checks) + " configurations checked, " + std::to_string(plan.nodes) + " nodes";
}

/// Plans, then shortens the path; measures the duration of both.
template <typename Plan, typename Shorten>
PlanOutcome timed(const PlanOptions& options, const Plan& plan, const Shorten& shorten) {
  PlanOutcome outcome;
  outcome.method = options.method;
  outcome.seed = options.seed;
  const auto began = Clock::now();
  outcome.plan = plan(began);
  outcome.planning_us = microseconds_since(began);
  outcome.effort = effort_of(outcome.plan);
  outcome.found = outcome.plan.path;
  if (!outcome.plan.solved() || !options.simplify) return outcome;
  const auto shortening = Clock::now();
  shorten(outcome.plan);
  outcome.simplify_us = microseconds_since(shortening);
  return outcome;
}

/// Shows the progress of planning, and ends it after a signal or at the end of the budget.
class PlanWatch {
 public:
  PlanWatch(std::string method, double budget) : method_(std::move(method)), budget_(budget) {}

  /// `spent` and the budget are both real or both virtual time [s].
  [[nodiscard]] bool ended(double spent) {
    if (interruption_.requested()) {
      interrupted_ = interruption_.after(std::min(spent, budget_), budget_, "s");
      return true;
    }
    progress_.show(method_, std::floor(spent), budget_, "s at most");
    return spent > budget_;
  }
  /// Clears the progress. Sets the outcome to what a signal has left of it.
  void conclude(PlanOutcome& outcome) {
    progress_.clear();
    outcome.interrupted = interrupted_;
    if (!interrupted_ || outcome.plan.solved()) return;
    outcome.plan.reason = "no path was found before the signal: " + outcome.effort;
  }

 private:
  std::string method_;
  double budget_;  ///< [s]
  std::optional<Interrupted> interrupted_;
  Interruption interruption_;
  Progress progress_;
};

PlanOutcome by_search(const PlanQuery& query, const global::Validity& validity, const PlanOptions& options,
                      PlanWatch& watch) {
  global::PlanOptions plan_options;
  plan_options.planner = global::built_in_planners().at(options.method);
  plan_options.seed = options.seed;
  plan_options.simplify = false;
  plan_options.shortcuts.clearance = options.keep;
  global::SearchRecord record;
  if (!options.plot.empty()) plan_options.record = &record;
  PlanOutcome outcome = timed(
      options,
      [&](Clock::time_point began) {
        plan_options.budget.ended = [began, &watch] { return watch.ended(1e-6 * microseconds_since(began)); };
        return global::plan(validity, query.start, query.goal, plan_options);
      },
      [&](global::Plan& plan) { global::simplify(validity, plan_options, plan); });
  outcome.record = std::move(record);
  return outcome;
}

PlanOutcome by_field(const PlanQuery& query, const PlanOptions& options) {
  FieldQuery field(query, options.clearance);
  return timed(
      options, [&](Clock::time_point) { return field.plan(); },
      [&](global::Plan& plan) { field.refine(plan, options.keep); });
}

/// The path is the simulated motion, which is not shortened.
PlanOutcome by_simulation(const PlanQuery& query, const global::Validity& validity, const PlanOptions& options,
                          PlanWatch& watch) {
  PlanOutcome outcome;
  outcome.method = options.method;
  outcome.seed = options.seed;
  const auto began = Clock::now();
  SimulatedPlan simulated = plan_by_simulation(query, validity, options.method, options.seed, options.plot,
                                               [&watch](double time) { return watch.ended(time); });
  outcome.planning_us = microseconds_since(began);
  outcome.plan = std::move(simulated.plan);
  outcome.duration = simulated.duration;
  outcome.effort = "simulated " + duration_text(simulated.duration) + ", " + std::to_string(outcome.plan.iterations) +
                   (outcome.plan.iterations == 1 ? " search, " : " searches, ") + std::to_string(outcome.plan.nodes) +
                   " points known";
  if (simulated.plots > 0)
    std::fprintf(stderr, "%d plots in %s\n", simulated.plots, config::valid_utf8(options.plot).c_str());
  return outcome;
}

/// Each sample takes a line.
void limit_samples(double period, double duration) {
  constexpr double kMost = 1e6;
  if (period <= 0.0 || period * kMost >= duration) return;
  throw Failure(ExitCode::kBadInput, "--trajectory = " + duration_text(period) + " must be at least " +
                                         duration_text(duration / kMost) +
                                         ", for at most a million samples of a motion of " + duration_text(duration));
}

/// Computes the trajectory. Rounded corners keep the clearance that shortening keeps, or 0.9 of the path's clearance.
void time_path(const global::Validity& validity, const PlanOptions& options, PlanOutcome& outcome) {
  const auto began = Clock::now();
  global::TimedPathOptions timing;
  timing.blend.deviation = options.deviation;
  const double beyond = outcome.obstacle_clearance - options.clearance;
  timing.clearance = std::clamp(0.9 * beyond, 0.0, options.keep);
  outcome.trajectory = options.jerk > 0.0
                           ? global::jerk_limited_path(validity, outcome.plan.path, options.jerk, timing)
                           : planner::AveragedTrajectory(global::timed_path(validity, outcome.plan.path, timing));
  outcome.timing_us = microseconds_since(began);
  outcome.duration = outcome.trajectory.duration();
  limit_samples(options.period, outcome.duration);
}

/// Throws Failure (usage) for options that the method ignores.
void refuse_ignored_options(const CLI::App& command, const PlanOptions& options) {
  const auto refuse = [&](std::initializer_list<const char*> names, const char* why) {
    for (const char* name : names) {
      if (command.count(name) == 0) continue;
      throw Failure(ExitCode::kUsage, std::string(name) + " is not for " + options.method + ": " + why);
    }
  };
  const Path path = motion_path(options.method);
  if (path == Path::kWalk) {
    refuse({"--trajectory", "--jerk", "--deviation", "--clearance", "--keep", "--step"},
           "the parameters of the arm in the cell file decide its motion");
  }
  if (path == Path::kDescent) refuse({"--budget", "--step"}, "the descent has one path and no time limit");
}

/// What a configuration must satisfy as the goal. A sensor-only method knows no obstacles before it moves.
planner::ConfigurationCheck goal_check(const PlanQuery& query, const global::Validity& validity,
                                       const PlanOptions& options) {
  if (motion_path(options.method) == Path::kWalk) {
    return [&query](const planner::JointVector& q) {
      return planner::reject_goal(planner::CellGeometry({query.first.arm}, 0), q, {});
    };
  }
  return [&validity](const planner::JointVector& q) -> std::optional<planner::Rejection> {
    auto reason = global::reject(validity, "goal", std::span(q.data(), static_cast<std::size_t>(q.size())));
    if (!reason) return std::nullopt;
    return planner::Rejection{planner::RejectionKind::kInCollision, {}, std::move(*reason)};
  };
}

PlanOutcome rejected(const PlanOptions& options, planner::ToolGoalAnswer tool) {
  PlanOutcome outcome;
  outcome.method = options.method;
  outcome.seed = options.seed;
  outcome.plan.status = global::PlanStatus::kGoalInvalid;
  outcome.plan.reason = std::move(tool.rejection->text);
  outcome.nearest = std::move(tool.nearest);
  return outcome;
}

/// Before planning, so that no plan is lost.
void require_writable_plot(const std::string& plot) {
  if (!std::ofstream(plot, std::ios::app)) throw Failure(ExitCode::kBadInput, "--plot: " + plot + " cannot be written");
}

/// An empty word such as --to '' comes from an unset variable of a script.
void refuse_empty(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const auto& words = option->results();
    if (std::find(words.begin(), words.end(), "") == words.end()) continue;
    throw Failure(ExitCode::kBadInput, option->get_name() + " = '' must not be empty: omit it or give a value");
  }
}

void write_plot(const PlanQuery& query, const global::Validity& validity, const PlanOutcome& outcome,
                const PlanOptions& options) {
  std::ofstream file(options.plot);
  file << plan_plot(query, validity, outcome, motion_path(options.method) == Path::kDescent);
  if (!file.flush()) throw Failure(ExitCode::kBadInput, "--plot: " + options.plot + " cannot be written");
}

ExitCode run_plan(const Settings& settings, const PlanOptions& options) {
  PlanQuery query = make_plan_query(options.arguments);
  const Path path = motion_path(options.method);
  const bool simulates = path == Path::kWalk;
  if (!options.plot.empty() && !simulates) {
    (void)only_arm(query, "--plot");
    require_writable_plot(options.plot);
  }
  global::ValidityOptions validity_options;
  validity_options.step = options.step;
  validity_options.padding = options.clearance;
  const global::Validity validity(query.planned, query.world, validity_options);
  planner::ToolGoalAnswer tool;
  if (query.tool) tool = resolve_tool_goal(query, goal_check(query, validity, options));
  PlanWatch watch(options.method, simulates ? query.time_limit : options.budget);
  PlanOutcome outcome = tool.rejection           ? rejected(options, std::move(tool))
                        : simulates              ? by_simulation(query, validity, options, watch)
                        : path == Path::kDescent ? by_field(query, options)
                                                 : by_search(query, validity, options, watch);
  watch.conclude(outcome);
  if (outcome.plan.solved()) {
    outcome.clearance = smallest_clearance(validity, outcome.plan, global::Validity::Pairs::kAll);
    outcome.obstacle_clearance = smallest_clearance(validity, outcome.plan, global::Validity::Pairs::kNotOwn);
    if (!simulates) time_path(validity, options, outcome);
  }
  for (const std::string& note : query.notes) {
    outcome.findings.push_back({config::Severity::kNote, note});
    std::fprintf(stderr, "note: %s\n", config::sentence_text(note).c_str());
  }
  if (!options.plot.empty() && !simulates && !query.goal.empty()) write_plot(query, validity, outcome, options);
  print(settings, plan_json(outcome, options.period), plan_text(outcome, options.period, Palette::for_stream(stdout)));
  if (outcome.interrupted) return outcome.interrupted->exit_code();
  return outcome.plan.solved() ? ExitCode::kDone : ExitCode::kNegative;
}

}  // namespace

void add_plan(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("plan", "Plans one path around all obstacles, without network");
  auto options = std::make_shared<PlanOptions>();
  PlanArguments& arguments = options->arguments;
  command->add_option("FILE", arguments.file, "cell file (YAML), robot description (URDF) or name of a robot")
      ->required();
  std::vector<std::string> methods;
  for (const auto& planner : global::built_in_planners().planners()) methods.emplace_back(planner->traits().name);
  for (const planner::MethodTraits& traits : planner::built_in_methods().traits()) {
    if (traits.path != Path::kNone) methods.emplace_back(traits.name);
  }
  add_choice(*command, "--method", options->method, methods, "planner or motion method (" + options->method + ")");
  command
      ->add_option("--arm", arguments.arms, "cell only: arm to plan for (the first); several arms are planned together")
      ->expected(1)
      ->take_all()
      ->type_name("NAME");
  command
      ->add_option(
          "--from", arguments.from,
          "joint values, one arm after the other, or a named pose (the request's start, or where the arms start)")
      ->type_name("Q");
  CLI::Option* to = command->add_option("--to", arguments.to, "the goal, in the same form (the request's goal)");
  to->type_name("Q");
  add_tool_goal_options(*command, *command, arguments.tool);
  to->excludes(command->get_option("--pose"))->excludes(command->get_option("--position"));
  command
      ->add_option("--moveit-scene", arguments.moveit_scene,
                   "MoveIt planning scene (YAML), of which the objects are added")
      ->type_name("FILE");
  command
      ->add_option("--moveit-request", arguments.moveit_request,
                   "MoveIt motion plan request (YAML), with start and goal")
      ->type_name("FILE");
  add_seed(*command, options->seed, "of all random choices: the same seed gives the same path (1)");
  add_duration(*command, "--budget", options->budget, "time limit of planning (10s)", 1e-6, 3600.0);
  constexpr config::Bounds kStep{1e-4, 1.0, "rad | m"};
  add_number(
      *command, "--step", [options = options.get()](double step) { options->step = step; },
      "distance of checked configurations on a segment [rad | m] (0.03)", kStep);
  constexpr config::Bounds kClearance{0.0, 1.0, "m"};
  add_number(
      *command, "--clearance", [options = options.get()](double distance) { options->clearance = distance; },
      "distance kept from all obstacles and other arms [m] (0)", kClearance);
  add_number(
      *command, "--keep", [options = options.get()](double distance) { options->keep = distance; },
      "distance beyond --clearance that shortening keeps if possible [m] (0.01)", kClearance);
  constexpr config::Bounds kDeviation{0.0, 1.0, "rad | m"};
  add_number(
      *command, "--deviation", [options = options.get()](double deviation) { options->deviation = deviation; },
      "deviation of rounded corners from the path [rad | m]; 0: the arm stops at corners (0.05)", kDeviation);
  add_duration(*command, "--trajectory", options->period, "also print the trajectory with this sampling period", 1e-4,
               3600.0);
  constexpr config::Bounds kJerk{0.1, 1e6, "rad/s³ | m/s³"};
  add_number(
      *command, "--jerk", [options = options.get()](double jerk) { options->jerk = jerk; },
      "limit of every joint's jerk (none)", kJerk);
  command->add_flag("!--raw", options->simplify, "print the found path without shortening it");
  command
      ->add_option("--plot", options->plot,
                   "plot one arm on its path into this file, as SVG, with the tree or roadmap of two joints; with "
                   "sensed_cspace or known_cspace every step into this folder")
      ->type_name("FILE|DIR");
  add_robot_options(*command, arguments.robot);
  std::string planners = "Global planners:\n";
  for (const auto& planner : global::built_in_planners().planners()) {
    const auto& [name, summary] = planner->traits();
    planners += "  " + std::string(name) + ": " + std::string(summary) + "\n";
  }
  command->footer(
      planners +
      "Goals of --pose and --position are of one arm's tool; the first joint positions found for them are the goal.\n"
      "Planners sensed_cspace and known_cspace simulate the arm in virtual time, for at most tasks.time_limit.\n"
      "For these --seed is the seed of the sensor noise, and --budget and --raw have no effect.\n"
      "Links of one arm must not touch, whatever --clearance is.\n"
      "Exit code 1 when no path was found; the output has the reason. After Ctrl-C a path that is found already is "
      "printed,\n"
      "though it may not be shortened.");
  command->callback([&session, options, command] {
    check_tool_goal_options(*command);
    session.action = [&session, options, command] {
      refuse_empty(*command);
      refuse_ignored_options(*command, *options);
      if (!is_robot(options->arguments.file)) refuse_robot_options(*command);
      if (is_robot(options->arguments.file) && !options->arguments.arms.empty()) {
        throw Failure(ExitCode::kUsage, "--arm is for a cell file: a URDF has one arm");
      }
      return run_plan(session.settings, *options);
    };
  });
}

}  // namespace hecaton::services::cli
