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
#include "services/cli/choice_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/document.hpp"
#include "services/cli/failure.hpp"
#include "services/cli/method_option.hpp"
#include "services/cli/plan_by_cspace.hpp"
#include "services/cli/plan_by_field.hpp"
#include "services/cli/plan_query.hpp"
#include "services/cli/quantities.hpp"
#include "services/cli/task_options.hpp"
#include "services/cli/terminal.hpp"

namespace hecaton::services::cli {
namespace {

namespace global = planner::global;
using Clock = std::chrono::steady_clock;

/// Methods of their own: they do not search among all configurations.
constexpr const char* kByField = "potential_field";
constexpr std::array kByCspace = {planner::Method::kSensedCspace, planner::Method::kKnownCspace};

constexpr std::array kMethods = {global::Method::kRrtConnect, global::Method::kRrt, global::Method::kEst,
                                 global::Method::kPrm};

struct Options {
  PlanWords words;
  std::string method = "rrt_connect";
  std::uint64_t seed = 1;
  double budget = 10.0;    ///< [s]
  double step = 0.03;      ///< [rad | m]
  double clearance = 0.0;  ///< [m]
  bool simplify = true;
  std::string plot;  ///< file for a picture; empty: none
};

double microseconds_since(Clock::time_point began) {
  return std::chrono::duration<double, std::micro>(Clock::now() - began).count();
}

/// The smallest exact distance on the path, looked at ten times as finely as the planner does.
double smallest_clearance(const global::Validity& validity, const global::Plan& plan) {
  double smallest = HUGE_VAL;
  for (std::size_t i = 0; i + 1 < plan.path.size(); ++i) {
    const auto& a = plan.path[i];
    const auto& b = plan.path[i + 1];
    double length2 = 0.0;
    for (std::size_t j = 0; j < a.size(); ++j) length2 += std::pow(b[j] - a[j], 2);
    const int steps = std::max(1, static_cast<int>(std::ceil(10.0 * std::sqrt(length2) / validity.options().step)));
    for (int k = 0; k <= steps; ++k) {
      std::vector<double> q(a.size());
      for (std::size_t j = 0; j < a.size(); ++j) q[j] = a[j] + k * (b[j] - a[j]) / steps;
      smallest = std::min(smallest, validity.nearest(q).distance);
    }
  }
  return smallest;
}

std::string status_name(global::PlanStatus status) {
  switch (status) {
    case global::PlanStatus::kSolved:
      return "solved";
    case global::PlanStatus::kStartInvalid:
      return "start_invalid";
    case global::PlanStatus::kGoalInvalid:
      return "goal_invalid";
    case global::PlanStatus::kBudgetEnded:
      return "budget_ended";
    case global::PlanStatus::kStuck:
      return "stuck";
  }
  return "";
}

struct Outcome {
  global::Plan plan;
  double planning_us = 0.0;
  double simplify_us = 0.0;
  double clearance = HUGE_VAL;  ///< [m]
  std::string effort;           ///< in words, for people
};

std::string effort_of(const global::Plan& plan) {
  return std::to_string(plan.checks) + " configurations checked, " + std::to_string(plan.nodes) + " nodes";
}

Json to_json(const Outcome& outcome, const Options& options) {
  const global::Plan& plan = outcome.plan;
  Json json = {{"solved", plan.solved()},
               {"status", status_name(plan.status)},
               {"reason", plan.reason},
               {"method", options.method},
               {"seed", options.seed},
               {"planning_us", outcome.planning_us},
               {"simplify_us", outcome.simplify_us},
               {"checks", plan.checks},
               {"iterations", plan.iterations},
               {"nodes", plan.nodes},
               {"path", plan.path},
               {"length", plan.solved() ? Json(plan.length) : Json(nullptr)},
               {"min_clearance_m", plan.solved() ? Json(outcome.clearance) : Json(nullptr)}};
  return json;
}

std::string table_text(const Outcome& outcome, const Options& options, const Palette& palette) {
  const global::Plan& plan = outcome.plan;
  if (!plan.solved()) return palette.red("not solved") + ": " + plan.reason + "\n";
  std::string text =
      palette.green("solved") + " by " + options.method + " in " + duration_text(1e-6 * outcome.planning_us);
  if (outcome.simplify_us > 0.0) text += ", simplified in " + duration_text(1e-6 * outcome.simplify_us);
  text += "; " + outcome.effort + "\nlength " + decimal_text(plan.length, 3) + ", smallest clearance " +
          distance_text(outcome.clearance) + "\n";
  for (const auto& q : plan.path) {
    for (std::size_t j = 0; j < q.size(); ++j) text += (j == 0 ? "" : " ") + decimal_text(q[j], 4);
    text += "\n";
  }
  return text;
}

/// Plans, then shortens what was found; both are timed.
template <typename Plan, typename Shorten>
Outcome timed(const Options& options, const Plan& plan, const Shorten& shorten) {
  Outcome outcome;
  const auto began = Clock::now();
  outcome.plan = plan(began);
  outcome.planning_us = microseconds_since(began);
  outcome.effort = effort_of(outcome.plan);
  if (!outcome.plan.solved() || !options.simplify) return outcome;
  const auto shortening = Clock::now();
  shorten(outcome.plan);
  outcome.simplify_us = microseconds_since(shortening);
  return outcome;
}

Outcome by_search(const PlanQuery& query, const global::Validity& validity, const Options& options) {
  global::PlanOptions plan_options;
  plan_options.method = *std::find_if(kMethods.begin(), kMethods.end(),
                                      [&](global::Method method) { return name_of(method) == options.method; });
  plan_options.seed = options.seed;
  plan_options.simplify = false;
  return timed(
      options,
      [&](Clock::time_point began) {
        plan_options.budget.ended = [began, &options] { return microseconds_since(began) > 1e6 * options.budget; };
        return global::plan(validity, query.start, query.goal, plan_options);
      },
      [&](global::Plan& plan) { global::simplify(validity, plan_options, plan); });
}

Outcome by_field(const PlanQuery& query, const Options& options) {
  FieldQuery field(query, options.clearance);
  return timed(
      options, [&](Clock::time_point) { return field.plan(); }, [&](global::Plan& plan) { field.refine(plan); });
}

std::optional<planner::Method> cspace_method(const Options& options) {
  const auto* found = std::find_if(kByCspace.begin(), kByCspace.end(),
                                   [&](planner::Method method) { return method_name(method) == options.method; });
  return found == kByCspace.end() ? std::nullopt : std::optional(*found);
}

/// The path is the one that the arm went: nothing is shortened.
Outcome by_cspace(const PlanQuery& query, const global::Validity& validity, planner::Method method,
                  const Options& options) {
  Outcome outcome;
  const auto began = Clock::now();
  CspaceWalk walk = plan_by_cspace(query, validity, method, options.seed, options.plot);
  outcome.planning_us = microseconds_since(began);
  outcome.plan = std::move(walk.plan);
  outcome.effort = "gone in " + duration_text(walk.duration) + ", " + std::to_string(outcome.plan.iterations) +
                   (outcome.plan.iterations == 1 ? " search, " : " searches, ") + std::to_string(outcome.plan.nodes) +
                   " points known";
  if (walk.pictures > 0) std::fprintf(stderr, "%d pictures in %s\n", walk.pictures, options.plot.c_str());
  return outcome;
}

void draw(const PlanQuery& query, const Outcome& outcome, const Options& options) {
  std::ofstream file(options.plot);
  file << plan_picture(query, outcome.plan, options.method == kByField, options.method);
  if (!file.flush()) throw Failure(ExitCode::kBadInput, "--plot: " + options.plot + " cannot be written");
}

ExitCode run(const Settings& settings, const Options& options) {
  const PlanQuery query = make_plan_query(options.words);
  global::ValidityOptions validity_options;
  validity_options.step = options.step;
  validity_options.padding = options.clearance;
  const global::Validity validity(query.planned, query.world, validity_options);
  const auto cspace = cspace_method(options);
  Outcome outcome = cspace                       ? by_cspace(query, validity, *cspace, options)
                    : options.method == kByField ? by_field(query, options)
                                                 : by_search(query, validity, options);
  if (outcome.plan.solved()) outcome.clearance = smallest_clearance(validity, outcome.plan);
  if (!options.plot.empty() && !cspace) draw(query, outcome, options);
  print(settings, to_json(outcome, options), table_text(outcome, options, Palette::for_stream(stdout)));
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
  for (const global::Method method : kMethods) methods.emplace_back(name_of(method));
  methods.emplace_back(kByField);
  for (const planner::Method method : kByCspace) methods.emplace_back(method_name(method));
  add_choice(*command, "--method", options->method, methods, "how paths are found (rrt_connect)");
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
  add_duration(*command, "--budget", options->budget, "how long to search (10s)", 1e-6, 3600.0);
  constexpr config::Bounds kStep{1e-4, 1.0, "rad | m"};
  add_number(
      *command, "--step", [options = options.get()](double step) { options->step = step; },
      "between configurations that are checked on a straight way, in joint space (0.03)", kStep);
  constexpr config::Bounds kClearance{0.0, 1.0, "m"};
  add_number(
      *command, "--clearance", [options = options.get()](double distance) { options->clearance = distance; },
      "distance to keep from all obstacles and other arms (0)", kClearance);
  command->add_flag("!--raw", options->simplify, "print the path as it was found, without shortening it");
  command
      ->add_option("--plot", options->plot,
                   "draw one arm on its path into this file, as SVG; with sensed_cspace or known_cspace every step of "
                   "it, in workspace and C-space, into this folder")
      ->type_name("FILE|DIR");
  add_robot_options(*command, words.robot);
  command->footer(
      "By sensed_cspace and known_cspace the arm goes its way in virtual time, for tasks.time_limit at most; --seed "
      "is\n"
      "that of its sensors' noise, --budget and --raw do not matter.\n"
      "Exit code 1 when there is no path: the reason says why.");
  command->callback([&session, options, command] {
    check_robot_options(options->words.robot);
    session.action = [&session, options, command] {
      if (!is_robot(options->words.file)) refuse_robot_options(*command);
      if (is_robot(options->words.file) && !options->words.arms.empty()) {
        throw Failure(ExitCode::kUsage, "--arm is for a cell file alone: a URDF is one arm");
      }
      return run(session.settings, *options);
    };
  });
}

}  // namespace hecaton::services::cli
