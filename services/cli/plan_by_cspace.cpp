#include "services/cli/plan_by_cspace.hpp"

#include <cmath>
#include <optional>
#include <span>

#include "planner/goal_check.hpp"
#include "planner/methods/registry.hpp"
#include "planner/simulation/cell_simulation.hpp"
#include "services/cli/episode_plotter.hpp"
#include "services/cli/plot_cspace.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"

namespace hecaton::services::cli {
namespace {

using planner::JointVector;
using planner::global::PlanStatus;

/// What is as near to the straight way between its neighbours is left out of a path [rad].
constexpr double kThinned = 5e-4;

/// The planned arm alone among what stands in its way.
planner::Cell cell_of(const PlanQuery& query, const std::string& method) {
  planner::Cell cell;
  cell.name = query.first.arm.name;
  cell.arms.push_back(query.first);
  planner::PlannedArm& planned = cell.arms.front();
  // An arm of a robot description has no methods of its own, and goes by their defaults.
  if (!planned.select_method(method)) planned.parameters.method = planner::built_in_method(method);
  cell.scene.obstacles = standing(query, "--method " + method);
  cell.timing = query.timing;
  cell.tasks.time_limit = query.time_limit;
  if (const auto objection = planned.objection()) throw Failure(ExitCode::kBadInput, "--method = " + *objection);
  return cell;
}

double off_segment(const JointVector& p, const JointVector& a, const JointVector& b) {
  const JointVector way = b - a;
  const double share = way.squaredNorm() > 0.0 ? std::clamp((p - a).dot(way) / way.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - share * way).norm();
}

/// Douglas and Peucker: what of the path after its first configuration is kept, its last one included.
void thin(std::span<const JointVector> path, std::vector<std::vector<double>>& kept) {
  std::size_t farthest = 0;
  double off = kThinned;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const double distance = off_segment(path[i], path.front(), path.back());
    if (distance > off) {
      off = distance;
      farthest = i;
    }
  }
  if (farthest == 0) {
    kept.emplace_back(path.back().begin(), path.back().end());
    return;
  }
  thin(path.first(farthest + 1), kept);
  thin(path.subspan(farthest), kept);
}

void keep_path(const std::vector<JointVector>& path, planner::global::Plan& plan) {
  plan.path.emplace_back(path.front().begin(), path.front().end());
  thin(path, plan.path);
  for (std::size_t i = 1; i < path.size(); ++i) plan.length += (path[i] - path[i - 1]).norm();
}

/// True when it has told why start or goal cannot be. A method that knows obstacles by its sensors alone: only limits
/// and the arm itself refuse its goal.
bool refuse_ends(const PlanQuery& query, const planner::global::Validity& validity, bool sensor_only,
                 const JointVector& goal, planner::global::Plan& plan) {
  const auto refuse = [&](PlanStatus status, const std::string& reason) {
    plan.status = status;
    plan.reason = reason;
    return true;
  };
  if (const auto reason = planner::global::reject(validity, "start", query.start)) {
    return refuse(PlanStatus::kStartInvalid, *reason);
  }
  if (sensor_only) {
    const auto rejection = planner::reject_goal(planner::CellGeometry({query.first.arm}, 0), goal, {});
    return rejection && refuse(PlanStatus::kGoalInvalid, rejection->text);
  }
  const auto reason = planner::global::reject(validity, "goal", query.goal);
  return reason && refuse(PlanStatus::kGoalInvalid, *reason);
}

}  // namespace

CspaceWalk plan_by_cspace(const PlanQuery& query, const planner::global::Validity& validity, const std::string& method,
                          std::uint64_t seed, const std::string& plot) {
  const planner::Cell cell = cell_of(query, method);
  const planner::CellConfiguration start{JointVector(
      Eigen::Map<const Eigen::VectorXd>(query.start.data(), static_cast<Eigen::Index>(query.start.size())))};
  const planner::CellConfiguration goal{
      JointVector(Eigen::Map<const Eigen::VectorXd>(query.goal.data(), static_cast<Eigen::Index>(query.goal.size())))};
  CspaceWalk walk;
  planner::global::Plan& plan = walk.plan;
  if (refuse_ends(query, validity, cell.arms[0].parameters.method->traits().sensor_only, goal[0], plan)) return walk;

  std::optional<EpisodePlotter> plotter;
  if (!plot.empty()) plotter.emplace(plot, cell);
  std::vector<JointVector> gone = start;
  std::optional<std::string> no_way;  // as of the last period
  planner::EpisodeOptions options;
  options.seed = seed;
  options.observe = [&](double time, const planner::CellConfiguration& measured,
                        std::span<const planner::ArmPlanner> planners) {
    gone.push_back(measured[0]);
    const planner::cspace::SensedPlanner& way = *cspace_of(planners[0].controller());
    plan.iterations = static_cast<std::uint64_t>(way.searches());
    plan.nodes = static_cast<int>(way.map().points().size());
    no_way = way.why_none(measured[0]);
    if (plotter) plotter->draw({cell, goal, time, measured, planners});
  };
  const planner::EpisodeOutcome outcome = planner::simulate_episode(cell, start, goal, options);
  if (plotter && plotter->failure()) throw Failure(ExitCode::kBadInput, *plotter->failure());
  if (plotter) walk.pictures = plotter->pictures();
  plan.checks = outcome.ticks;
  walk.duration = outcome.duration;
  if (outcome.referee.contacts > 0) {
    const world::Separation& touch = outcome.referee.smallest;
    plan.status = PlanStatus::kStuck;
    plan.reason = touch.a + " touched " + touch.b + ", which its sensors do not show in time";
  } else if (outcome.arms[0].outcome == planner::TaskOutcome::kReached) {
    plan.status = PlanStatus::kSolved;
    keep_path(gone, plan);
  } else if (no_way) {
    plan.status = PlanStatus::kStuck;
    plan.reason = *no_way;
  } else {
    plan.reason = "the arm was still on its way after tasks.time_limit = " + duration_text(query.time_limit);
  }
  return walk;
}

}  // namespace hecaton::services::cli
