#include "services/cli/plan_by_field.hpp"

#include <algorithm>
#include <cmath>

#include "planner/local/goal_objective.hpp"
#include "planner/methods/potential_field/refine_path.hpp"
#include "services/cli/plot_path.hpp"
#include "services/command_line/quantities.hpp"

namespace hecaton::services::cli {
namespace {

using planner::JointVector;
using planner::global::Plan;
using planner::global::PlanStatus;

/// Configurations of a path that a picture shows.
constexpr int kShown = 30;

constexpr const char* kWho = "--method potential_field";

planner::CellGeometry alone(const PlanQuery& query) {
  planner::CellGeometry geometry({only_arm(query, kWho)}, 0);
  geometry.set_obstacles(standing(query, kWho));
  return geometry;
}

std::vector<world::ObstacleState> states_of(const PlanQuery& query) {
  std::vector<world::ObstacleState> states;
  for (const world::Obstacle& obstacle : standing(query, kWho)) states.push_back({obstacle.X_WO, {}, 0.0});
  return states;
}

JointVector joints_of(const std::vector<double>& values) {
  return JointVector(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
}

std::vector<JointVector> joints_of(const std::vector<std::vector<double>>& path) {
  std::vector<JointVector> joints;
  for (const auto& q : path) joints.push_back(joints_of(q));
  return joints;
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

/// At equal distances on the path, ends included.
std::vector<JointVector> spread(const std::vector<JointVector>& path, int count) {
  const double whole = planner::potential::length(path);
  std::vector<JointVector> shown;
  double gone = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double piece = (path[i] - path[i - 1]).norm();
    while (piece > 0.0 && static_cast<double>(shown.size()) * whole / count <= gone + piece) {
      const double along = static_cast<double>(shown.size()) * whole / count - gone;
      shown.emplace_back(path[i - 1] + along / piece * (path[i] - path[i - 1]));
    }
    gone += piece;
  }
  if (!path.empty()) shown.push_back(path.back());
  return shown;
}

}  // namespace

FieldQuery::FieldQuery(const PlanQuery& query, double margin)
    : query_(query),
      geometry_(alone(query)),
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
    planner::potential::FreeMotion roomier(geometry_, states_of(query_), {}, margin_ + share * keep);
    if (!is_free(path, roomier)) continue;
    set_path(planner::potential::refine(path, roomier), plan);
    return;
  }
  set_path(planner::potential::refine(path, motion_), plan);
}

std::string plan_picture(const PlanQuery& query, const Plan& plan, bool field, const std::string& title,
                         std::vector<std::string> panels) {
  planner::PlannedArm planned;
  planned.arm = only_arm(query, "--plot");
  planned.methods = query.first.methods;
  const std::vector<world::Obstacle> obstacles = standing(query, "--plot");
  const JointVector goal = joints_of(query.goal);
  const std::vector<JointVector> path =
      plan.solved() ? spread(joints_of(plan.path), kShown) : std::vector<JointVector>{joints_of(query.start)};
  return plot_path({.planned = planned,
                    .obstacles = obstacles,
                    .path = path,
                    .goal = goal,
                    .title = title,
                    .field = field,
                    .panels = std::move(panels)});
}

}  // namespace hecaton::services::cli
