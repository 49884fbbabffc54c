#include <algorithm>

#include "services/cli/plan.hpp"
#include "services/cli/plots.hpp"
#include "services/command_line/options.hpp"

namespace hecaton::services::cli {
namespace {

using planner::JointVector;
using planner::global::PlanStatus;

constexpr int kPlotted = 30;  // intervals of the path between plotted configurations

std::string status_name(PlanStatus status) {
  switch (status) {
    case PlanStatus::kSolved:
      return "solved";
    case PlanStatus::kStartInvalid:
      return "start_invalid";
    case PlanStatus::kGoalInvalid:
      return "goal_invalid";
    case PlanStatus::kBudgetEnded:
      return "budget_ended";
    case PlanStatus::kStuck:
      return "stuck";
  }
  return "";
}

/// Calls `use` for every period of a solved plan, and for its end.
template <typename Use>
void for_each_sample(const PlanOutcome& outcome, double period, const Use& use) {
  const planner::AveragedTrajectory& trajectory = outcome.trajectory;
  if (trajectory.empty()) {  // the goal is the start
    const std::vector<double>& q = outcome.plan.path.front();
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(q.size()));
    use(0.0, planner::TrajectoryPoint{Eigen::Map<const Eigen::VectorXd>(q.data(), rest.size()), rest, rest});
    return;
  }
  const auto whole = static_cast<std::uint64_t>(std::ceil(trajectory.duration() / period - 1e-9));
  for (std::uint64_t i = 0; i <= whole; ++i) {
    const double t = std::min(static_cast<double>(i) * period, trajectory.duration());
    use(t, trajectory.at(t));
  }
}

std::vector<double> numbers(const Eigen::VectorXd& values) {
  return {values.begin(), values.end()};
}

Json samples(const PlanOutcome& outcome, double period) {
  Json list = Json::array();
  for_each_sample(outcome, period, [&](double t, const planner::TrajectoryPoint& at) {
    list.push_back({{"time_s", t}, {"q", numbers(at.q)}, {"qd", numbers(at.qd)}, {"qdd", numbers(at.qdd)}});
  });
  return {{"period_s", period}, {"samples", list}};
}

std::string row(const std::vector<double>& values) {
  std::string text;
  for (std::size_t j = 0; j < values.size(); ++j) text += (j == 0 ? "" : " ") + decimal_text(values[j], 4);
  return text + "\n";
}

/// `count` + 1 configurations at equal distances on the path, ends included.
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

/// The graph of the search, which can be plotted in two dimensions.
std::vector<PlotPanel> graph_panels(const PlanQuery& query, const planner::global::Validity& validity,
                                    const PlanOutcome& outcome) {
  if (validity.dimensions() != 2 || outcome.record.nodes.size() == 0) return {};
  const planner::RobotModel& model = *query.planned.front().own_arm().model;
  const auto label = [&](int joint) {
    const bool slides = std::ranges::any_of(model.links, [&](const planner::Link& link) {
      return link.joint == joint && link.joint_type == planner::JointType::kPrismatic;
    });
    return model.joint_names[joint] + (slides ? " [m]" : " [rad]");
  };
  const planner::global::Space space = space_of(validity, query.start, query.goal);
  return {graph_panel({.validity = validity,
                       .space = space,
                       .record = outcome.record,
                       .found = outcome.found,
                       .path = outcome.plan.path,
                       .start = query.start,
                       .goal = query.goal,
                       .across = label(0),
                       .up = label(1)})};
}

}  // namespace

double smallest_clearance(const planner::global::Validity& validity, const planner::global::Plan& plan,
                          planner::global::Validity::Pairs pairs) {
  double smallest = HUGE_VAL;
  for (std::size_t i = 0; i + 1 < plan.path.size(); ++i) {
    smallest = std::min(smallest, validity.clearance(plan.path[i], plan.path[i + 1], pairs));
  }
  return smallest;
}

Json plan_json(const PlanOutcome& outcome, double period) {
  const planner::global::Plan& plan = outcome.plan;
  const bool cut_short = outcome.interrupted && !plan.solved();
  Json json = {{"solved", plan.solved()},
               {"status", cut_short ? "interrupted" : status_name(plan.status)},
               {"reason", plan.reason.empty() ? Json(nullptr) : Json(plan.reason)},
               {"method", outcome.method},
               {"seed", outcome.seed},
               {"planning_us", outcome.planning_us},
               {"simplify_us", outcome.simplify_us},
               {"timing_us", outcome.timing_us},
               {"checks", plan.checks},
               {"iterations", plan.iterations},
               {"nodes", plan.nodes},
               {"path", plan.path},
               {"length", plan.solved() ? Json(plan.length) : Json(nullptr)},
               {"min_clearance_m", plan.solved() ? Json(outcome.clearance) : Json(nullptr)},
               {"min_obstacle_clearance_m", plan.solved() ? Json(outcome.obstacle_clearance) : Json(nullptr)},
               {"duration_s", plan.solved() ? Json(outcome.duration) : Json(nullptr)}};
  if (outcome.nearest) {
    json["nearest"] = {{"xyz_rpy", xyz_rpy_of(outcome.nearest->X_WT)}, {"angle_rad", outcome.nearest->angle}};
  }
  json["findings"] = findings_json(outcome.findings);
  json["interrupted"] = to_json(outcome.interrupted);
  if (period > 0.0) json["trajectory"] = plan.solved() ? samples(outcome, period) : Json(nullptr);
  return json;
}

std::string plan_text(const PlanOutcome& outcome, double period, const Palette& palette) {
  const planner::global::Plan& plan = outcome.plan;
  const std::string interrupted =
      outcome.interrupted ? palette.yellow("not complete") + ": " + outcome.interrupted->text() + "\n" : "";
  if (!plan.solved()) return palette.red("not solved") + ": " + plan.reason + "\n" + interrupted;
  std::string text = interrupted + palette.green("solved") + " by " + outcome.method + " in " +
                     duration_text(1e-6 * outcome.planning_us);
  if (outcome.simplify_us > 0.0) text += ", simplified in " + duration_text(1e-6 * outcome.simplify_us);
  text += "; " + outcome.effort + "\nlength " + decimal_text(plan.length, 3) + ", smallest clearance " +
          distance_text(outcome.clearance) + " (from obstacles and other arms " +
          distance_text(outcome.obstacle_clearance) + "), takes the arm " + duration_text(outcome.duration) + "\n";
  for (const auto& q : plan.path) text += row(q);
  if (period <= 0.0) return text;
  text += "trajectory: t q\n";
  for_each_sample(outcome, period, [&](double t, const planner::TrajectoryPoint& at) {
    std::vector<double> values = numbers(at.q);
    values.insert(values.begin(), t);
    text += row(values);
  });
  return text;
}

std::string plan_plot(const PlanQuery& query, const planner::global::Validity& validity, const PlanOutcome& outcome,
                      bool field) {
  planner::PlannedArm planned;
  planned.arm = only_arm(query, "--plot");
  planned.methods = query.first.methods;
  const std::vector<world::Obstacle> obstacles = obstacles_of_only_arm(query, "--plot");
  const JointVector goal = joints_of(query.goal);
  const std::vector<JointVector> path = outcome.plan.solved() ? spread(joints_of(outcome.plan.path), kPlotted)
                                                              : std::vector<JointVector>{joints_of(query.start)};
  return plot_path({.planned = planned,
                    .obstacles = obstacles,
                    .path = path,
                    .goal = goal,
                    .title = outcome.method,
                    .field = field,
                    .panels = graph_panels(query, validity, outcome)});
}

}  // namespace hecaton::services::cli
