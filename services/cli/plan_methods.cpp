#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "planner/goal_check.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/methods/potential_field/gradient_path.hpp"
#include "planner/methods/registry.hpp"
#include "planner/simulation/cell_simulation.hpp"
#include "services/cli/plan.hpp"
#include "services/cli/plots.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"

namespace hecaton::services::cli {
namespace {

using planner::JointVector;
using planner::global::Plan;
using planner::global::PlanStatus;

constexpr const char* kOption = "--method potential_field";

planner::CellGeometry geometry_of(const PlanQuery& query) {
  planner::CellGeometry geometry({only_arm(query, kOption)}, 0);
  geometry.set_obstacles(obstacles_of_only_arm(query, kOption));
  return geometry;
}

std::vector<world::ObstacleState> states_of(const PlanQuery& query) {
  std::vector<world::ObstacleState> states;
  for (const world::Obstacle& obstacle : obstacles_of_only_arm(query, kOption))
    states.push_back({obstacle.X_WO, {}, 0.0});
  return states;
}

void set_path(const std::vector<JointVector>& path, Plan& plan) {
  plan.path.clear();
  for (const JointVector& q : path) plan.path.emplace_back(q.begin(), q.end());
  plan.length = planner::potential::length(path);
}

PlanStatus status_of(planner::potential::DescentOutcome outcome) {
  using planner::potential::DescentOutcome;
  switch (outcome) {
    case DescentOutcome::kReached:
      return PlanStatus::kSolved;
    case DescentOutcome::kStartBlocked:
      return PlanStatus::kStartInvalid;
    case DescentOutcome::kGoalBlocked:
      return PlanStatus::kGoalInvalid;
    case DescentOutcome::kOutOfSteps:
      return PlanStatus::kBudgetEnded;
    default:
      return PlanStatus::kStuck;
  }
}

bool is_free(const std::vector<JointVector>& path, planner::potential::FreeMotion& motion) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    if (!motion.free(path[i], path[i + 1])) return false;
  }
  return true;
}

constexpr double kThinning = 5e-4;  // distance from the path of the configurations that are left out [rad | m]

/// A cell with the planned arm alone; other arms are obstacles.
planner::Cell cell_of(const PlanQuery& query, const std::string& method) {
  planner::Cell cell;
  cell.name = query.first.arm.name;
  cell.arms.push_back(query.first);
  planner::PlannedArm& planned = cell.arms.front();
  // The arm of a URDF has no method parameters: defaults.
  if (!planned.select_method(method)) planned.parameters.method = planner::built_in_method(method);
  cell.scene.obstacles = obstacles_of_only_arm(query, "--method " + method);
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

/// Douglas-Peucker: appends the configurations of `path` that are kept, without the first one.
void thin(std::span<const JointVector> path, std::vector<std::vector<double>>& kept) {
  std::size_t farthest = 0;
  double off = kThinning;
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

/// True if start or goal is invalid; sets status and reason. For a sensor-only method only the joint limits and
/// self-collision make a goal invalid.
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

JointVector joints_of(const std::vector<double>& values) {
  return JointVector(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
}

std::vector<JointVector> joints_of(const std::vector<std::vector<double>>& path) {
  std::vector<JointVector> joints;
  for (const auto& q : path) joints.push_back(joints_of(q));
  return joints;
}

FieldQuery::FieldQuery(const PlanQuery& query, double margin)
    : query_(query),
      geometry_(geometry_of(query)),
      field_(geometry_, planner::parameters_of<planner::potential::PotentialParameters>(query.first.methods)),
      margin_(margin),
      motion_(geometry_, states_of(query), {}, margin) {}

Plan FieldQuery::plan() {
  using planner::potential::DescentOutcome;
  const planner::JointLimits& limits = geometry_.own_arm().limits;
  const JointVector goal = joints_of(query_.goal);
  const auto descent = planner::potential::descend(field_, motion_, limits, joints_of(query_.start), goal);
  Plan plan;
  plan.status = status_of(descent.outcome);
  plan.iterations = static_cast<std::uint64_t>(descent.steps);
  plan.checks = static_cast<std::uint64_t>(descent.evaluations);
  plan.nodes = static_cast<int>(descent.path.size());
  if (plan.solved()) {
    set_path(descent.path, plan);
  } else if (descent.path.empty()) {
    plan.reason = std::string("the potential field has ") + describe(descent.outcome);
  } else {
    const double left = planner::joint_difference(limits, descent.path.back(), goal).norm();
    plan.reason = std::string("the descent ended in ") + describe(descent.outcome) + ", " + decimal_text(left, 3) +
                  " from the goal; rrt_connect may find a way";
  }
  return plan;
}

void FieldQuery::refine(Plan& plan, double keep) {
  const std::vector<JointVector> path = joints_of(plan.path);
  for (const double share : {1.0, 0.25}) {
    planner::potential::FreeMotion wider(geometry_, states_of(query_), {}, margin_ + share * keep);
    if (!is_free(path, wider)) continue;
    set_path(planner::potential::refine(path, wider), plan);
    return;
  }
  set_path(planner::potential::refine(path, motion_), plan);
}

SimulatedPlan plan_by_simulation(const PlanQuery& query, const planner::global::Validity& validity,
                                 const std::string& method, std::uint64_t seed, const std::string& plot,
                                 const std::function<bool(double)>& ended) {
  const planner::Cell cell = cell_of(query, method);
  const planner::CellConfiguration start{joints_of(query.start)};
  const planner::CellConfiguration goal{joints_of(query.goal)};
  SimulatedPlan result;
  planner::global::Plan& plan = result.plan;
  if (refuse_ends(query, validity, cell.arms[0].parameters.method->traits().sensor_only, goal[0], plan)) return result;

  std::optional<EpisodePlotter> plotter;
  if (!plot.empty()) plotter.emplace(plot, cell);
  std::vector<JointVector> path = start;
  std::optional<std::string> no_path;  // as of the last period
  double now = 0.0;
  planner::EpisodeOptions options;
  options.seed = seed;
  options.observe = [&](double time, const planner::CellConfiguration& measured,
                        std::span<const planner::ArmPlanner> planners) {
    now = time;
    path.push_back(measured[0]);
    const planner::cspace::SensedPlanner& planner = *cspace_of(planners[0].controller());
    plan.iterations = static_cast<std::uint64_t>(planner.searches());
    plan.nodes = static_cast<int>(planner.map().points().size());
    no_path = planner.no_path_reason(measured[0]);
    if (plotter) plotter->plot({cell, goal, time, time, measured, planners});
  };
  options.ended = [&] { return ended(now); };
  const planner::EpisodeOutcome outcome = planner::simulate_episode(cell, start, goal, options);
  if (plotter && plotter->failure()) throw Failure(ExitCode::kBadInput, *plotter->failure());
  if (plotter) result.plots = plotter->plots();
  plan.checks = outcome.ticks;
  result.duration = outcome.duration;
  if (outcome.contact_report.contacts > 0) {
    const world::Separation& touch = outcome.contact_report.smallest;
    plan.status = PlanStatus::kStuck;
    plan.reason = touch.a + " touched " + touch.b + ", which its sensors did not detect in time";
  } else if (outcome.arms[0].outcome == planner::TaskOutcome::kReached) {
    plan.status = PlanStatus::kSolved;
    keep_path(path, plan);
  } else if (no_path) {
    plan.status = PlanStatus::kStuck;
    plan.reason = *no_path;
  } else {
    plan.reason = "the arm did not reach the goal within tasks.time_limit = " + duration_text(query.time_limit);
  }
  return result;
}

}  // namespace hecaton::services::cli
