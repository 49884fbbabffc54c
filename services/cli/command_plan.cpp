/// hecaton plan: one path from here to there, without network.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "planner/global/plan.hpp"
#include "planner/global/registry.hpp"
#include "planner/global/timed_path.hpp"
#include "planner/methods/registry.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/plan_by_cspace.hpp"
#include "services/cli/plan_by_field.hpp"
#include "services/cli/plan_outcome.hpp"
#include "services/cli/plan_query.hpp"
#include "services/cli/plot_graph.hpp"
#include "services/cli/plot_path.hpp"
#include "services/cli/task_options.hpp"
#include "services/command_line/choice_option.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"
#include "services/command_line/terminal.hpp"

namespace hecaton::services::cli {
namespace {

namespace global = planner::global;
using Clock = std::chrono::steady_clock;

using Path = planner::MethodTraits::Path;

/// How a motion method of that name plans paths: it does not search among all configurations. kNone for global
/// planners.
Path motion_path(const std::string& name) {
  for (const planner::MethodTraits& traits : planner::built_in_methods().traits()) {
    if (traits.name == name) return traits.path;
  }
  return Path::kNone;
}

struct Options {
  PlanWords words;
  std::string method{global::default_planner()->traits().name};
  std::uint64_t seed = 1;
  double budget = 10.0;    ///< [s]
  double step = 0.03;      ///< [rad | m]
  double clearance = 0.0;  ///< [m]
  bool simplify = true;
  double keep = 0.01;       ///< clearance that shortening keeps where the path has it [m]
  double deviation = 0.05;  ///< of rounded corners [rad | m]
  double period = 0.0;      ///< of the trajectory's samples [s]; 0: none
  double jerk = 0.0;        ///< that no joint exceeds [rad/s³ | m/s³]; 0: not limited
  std::string plot;         ///< file for a picture; empty: none
};

double microseconds_since(Clock::time_point began) {
  return std::chrono::duration<double, std::micro>(Clock::now() - began).count();
}

std::string effort_of(const global::Plan& plan) {
  return std::to_string(plan.checks) + " configurations checked, " + std::to_string(plan.nodes) + " nodes";
}

/// Plans, then shortens what was found; both are timed.
template <typename Plan, typename Shorten>
PlanOutcome timed(const Options& options, const Plan& plan, const Shorten& shorten) {
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

PlanOutcome by_search(const PlanQuery& query, const global::Validity& validity, const Options& options) {
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
        plan_options.budget.ended = [began, &options] { return microseconds_since(began) > 1e6 * options.budget; };
        return global::plan(validity, query.start, query.goal, plan_options);
      },
      [&](global::Plan& plan) { global::simplify(validity, plan_options, plan); });
  outcome.record = std::move(record);
  return outcome;
}

PlanOutcome by_field(const PlanQuery& query, const Options& options) {
  FieldQuery field(query, options.clearance);
  return timed(
      options, [&](Clock::time_point) { return field.plan(); },
      [&](global::Plan& plan) { field.refine(plan, options.keep); });
}

/// The path is the one that the arm went: nothing is shortened.
PlanOutcome by_cspace(const PlanQuery& query, const global::Validity& validity, const Options& options) {
  PlanOutcome outcome;
  outcome.method = options.method;
  outcome.seed = options.seed;
  const auto began = Clock::now();
  CspaceWalk walk = plan_by_cspace(query, validity, options.method, options.seed, options.plot);
  outcome.planning_us = microseconds_since(began);
  outcome.plan = std::move(walk.plan);
  outcome.duration = walk.duration;
  outcome.effort = "gone in " + duration_text(walk.duration) + ", " + std::to_string(outcome.plan.iterations) +
                   (outcome.plan.iterations == 1 ? " search, " : " searches, ") + std::to_string(outcome.plan.nodes) +
                   " points known";
  if (walk.pictures > 0) std::fprintf(stderr, "%d pictures in %s\n", walk.pictures, options.plot.c_str());
  return outcome;
}

/// A sample takes a line: what nobody can read is no answer.
void require_few_samples(double period, double duration) {
  constexpr double kMost = 1e6;
  if (period <= 0.0 || period * kMost >= duration) return;
  throw Failure(ExitCode::kBadInput, "--trajectory = " + duration_text(period) + " must be at least " +
                                         duration_text(duration / kMost) + ", for at most a million samples of the " +
                                         duration_text(duration) + " that the arm takes");
}

/// Rounds corners where that keeps as much room as shortening has to, or as the path has.
void time_path(const global::Validity& validity, const Options& options, PlanOutcome& outcome) {
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
  require_few_samples(options.period, outcome.duration);
}

/// What the search has built, where that can be seen: in two dimensions.
std::vector<std::string> graph_panels(const PlanQuery& query, const global::Validity& validity,
                                      const PlanOutcome& outcome) {
  if (validity.dimensions() != 2 || outcome.record.nodes.size() == 0) return {};
  const std::vector<std::string>& joints = query.planned.front().own_arm().model->joint_names;
  const global::Space space = space_of(validity, query.start, query.goal);
  return {graph_panel({.validity = validity,
                       .space = space,
                       .record = outcome.record,
                       .found = outcome.found,
                       .path = outcome.plan.path,
                       .start = query.start,
                       .goal = query.goal,
                       .across = joints[0],
                       .up = joints[1]},
                      kPanel)};
}

/// A method that does not go by an option must not look as if it did.
void refuse_what_does_not_matter(const CLI::App& command, const Options& options) {
  const auto refuse = [&](std::initializer_list<const char*> names, const char* why) {
    for (const char* name : names) {
      if (command.count(name) == 0) continue;
      throw Failure(ExitCode::kUsage, std::string(name) + " is not for " + options.method + ": " + why);
    }
  };
  const Path path = motion_path(options.method);
  if (path == Path::kWalk) {
    refuse({"--trajectory", "--jerk", "--deviation", "--clearance", "--keep", "--step"},
           "the arm itself goes its way, as its parameters in the cell file say");
  }
  if (path == Path::kDescent) refuse({"--budget", "--step"}, "it goes down one way, for as long as that takes");
}

/// Before there is a plan that would be lost.
void require_writable(const std::string& plot) {
  if (!std::ofstream(plot, std::ios::app)) throw Failure(ExitCode::kBadInput, "--plot: " + plot + " cannot be written");
}

/// "--to ''" is what is left of a script's variable that was not set.
void refuse_empty(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const auto& words = option->results();
    if (std::find(words.begin(), words.end(), "") == words.end()) continue;
    throw Failure(ExitCode::kBadInput, option->get_name() + " = '' must not be empty: leave it out, or say what");
  }
}

void draw(const PlanQuery& query, const global::Validity& validity, const PlanOutcome& outcome,
          const Options& options) {
  std::ofstream file(options.plot);
  file << plan_picture(query, outcome.plan, motion_path(options.method) == Path::kDescent, options.method,
                       graph_panels(query, validity, outcome));
  if (!file.flush()) throw Failure(ExitCode::kBadInput, "--plot: " + options.plot + " cannot be written");
}

ExitCode run(const Settings& settings, const Options& options) {
  const PlanQuery query = make_plan_query(options.words);
  const Path path = motion_path(options.method);
  const bool walks = path == Path::kWalk;
  if (!options.plot.empty() && !walks) {
    (void)only_arm(query, "--plot");
    require_writable(options.plot);
  }
  global::ValidityOptions validity_options;
  validity_options.step = options.step;
  validity_options.padding = options.clearance;
  const global::Validity validity(query.planned, query.world, validity_options);
  PlanOutcome outcome = walks                    ? by_cspace(query, validity, options)
                        : path == Path::kDescent ? by_field(query, options)
                                                 : by_search(query, validity, options);
  if (outcome.plan.solved()) {
    outcome.clearance = smallest_clearance(validity, outcome.plan, global::Validity::Pairs::kAll);
    outcome.obstacle_clearance = smallest_clearance(validity, outcome.plan, global::Validity::Pairs::kNotOwn);
    if (!walks) time_path(validity, options, outcome);
  }
  outcome.notes = query.notes;
  for (const std::string& note : query.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  if (!options.plot.empty() && !walks) draw(query, validity, outcome, options);
  print(settings, plan_json(outcome, options.period), plan_text(outcome, options.period, Palette::for_stream(stdout)));
  return outcome.plan.solved() ? ExitCode::kDone : ExitCode::kNegative;
}

}  // namespace

void add_plan(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("plan", "Plans one path around everything that stands in the way, without network");
  auto options = std::make_shared<Options>();
  PlanWords& words = options->words;
  command->add_option("FILE", words.file, "cell file (YAML) or robot description (URDF)")->required();
  std::vector<std::string> methods;
  for (const auto& planner : global::built_in_planners().planners()) methods.emplace_back(planner->traits().name);
  for (const planner::MethodTraits& traits : planner::built_in_methods().traits()) {
    if (traits.path != Path::kNone) methods.emplace_back(traits.name);
  }
  add_choice(*command, "--method", options->method, methods, "how paths are found (" + options->method + ")");
  command->add_option("--arm", words.arms, "cell only: arm to plan for (the first); several are planned as one")
      ->expected(1)
      ->take_all()
      ->type_name("NAME");
  command
      ->add_option("--from", words.from,
                   "joint values (of all planned arms, one arm after the other) or a named pose; otherwise the "
                   "request's start, or where the arms start")
      ->type_name("Q");
  command->add_option("--to", words.to, "the goal, in the same form; otherwise the request's")->type_name("Q");
  command->add_option("--moveit-scene", words.moveit_scene, "MoveIt planning scene (YAML): its objects are added")
      ->type_name("FILE");
  command->add_option("--moveit-request", words.moveit_request, "MoveIt motion plan request (YAML): start and goal")
      ->type_name("FILE");
  add_seed(*command, options->seed, "of all random choices: the same seed gives the same path (1)");
  add_duration(*command, "--budget", options->budget, "how long to search and shorten, at most (10s)", 1e-6, 3600.0);
  constexpr config::Bounds kStep{1e-4, 1.0, "rad | m"};
  add_number(
      *command, "--step", [options = options.get()](double step) { options->step = step; },
      "between configurations that are checked on a straight way, in joint space [rad | m] (0.03)", kStep);
  constexpr config::Bounds kClearance{0.0, 1.0, "m"};
  add_number(
      *command, "--clearance", [options = options.get()](double distance) { options->clearance = distance; },
      "distance to keep from all obstacles and other arms [m] (0)", kClearance);
  add_number(
      *command, "--keep", [options = options.get()](double distance) { options->keep = distance; },
      "distance beyond --clearance that shortening keeps, where the path that was found has it [m] (0.01)", kClearance);
  constexpr config::Bounds kDeviation{0.0, 1.0, "rad | m"};
  add_number(
      *command, "--deviation", [options = options.get()](double deviation) { options->deviation = deviation; },
      "how far rounded corners may leave the path, in joint space [rad | m]; 0: the arm stops at every corner (0.05)",
      kDeviation);
  add_duration(*command, "--trajectory", options->period,
               "also print the trajectory, sampled so often: positions, velocities, accelerations", 1e-4, 3600.0);
  constexpr config::Bounds kJerk{0.1, 1e6, "rad/s³ | m/s³"};
  add_number(
      *command, "--jerk", [options = options.get()](double jerk) { options->jerk = jerk; },
      "also limit every joint's jerk, in the trajectory and in how long the arm takes (unlimited)", kJerk);
  command->add_flag("!--raw", options->simplify, "print the path as it was found, without shortening it");
  command
      ->add_option("--plot", options->plot,
                   "draw one arm on its path into this file, as SVG, beside it, for a robot of two joints, the tree or "
                   "roadmap; with sensed_cspace or known_cspace every step of it, in workspace and C-space, into this "
                   "folder")
      ->type_name("FILE|DIR");
  add_robot_options(*command, words.robot);
  std::string planners = "Global planners:\n";
  for (const auto& planner : global::built_in_planners().planners()) {
    const auto& [name, summary] = planner->traits();
    planners += "  " + std::string(name) + ": " + std::string(summary) + "\n";
  }
  command->footer(
      planners +
      "By sensed_cspace and known_cspace the arm goes its way in virtual time, for tasks.time_limit at most;\n"
      "--seed is that of its sensors' noise, --budget and --raw do not matter.\n"
      "Links of one arm only must not touch each other, whatever --clearance is.\n"
      "Exit code 1 when there is no path: the reason says why.");
  command->callback([&session, options, command] {
    check_robot_options(options->words.robot);
    session.action = [&session, options, command] {
      refuse_empty(*command);
      refuse_what_does_not_matter(*command, *options);
      if (!is_robot(options->words.file)) refuse_robot_options(*command);
      if (is_robot(options->words.file) && !options->words.arms.empty()) {
        throw Failure(ExitCode::kUsage, "--arm is for a cell file alone: a URDF is one arm");
      }
      return run(session.settings, *options);
    };
  });
}

}  // namespace hecaton::services::cli
