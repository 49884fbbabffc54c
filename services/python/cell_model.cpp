#include "services/python/cell_model.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include <hecaton/client.hpp>

#include "planner/global/timed_path.hpp"
#include "planner/goal_check.hpp"
#include "planner/model/kinematics.hpp"
#include "services/config/overlaps.hpp"
#include "services/python/unknown_name.hpp"

namespace hecaton::python {

namespace global = planner::global;
using planner::JointVector;
using Clock = std::chrono::steady_clock;

namespace {

constexpr double kJointStep = 0.03;      // of path checks that are not proven, as `hecaton plan` has it [rad | m]
constexpr double kKeptClearance = 0.01;  // that shortening and rounding keep where the path has it [m]

std::vector<world::Obstacle> obstacles_at_begin(const planner::Cell& cell) {
  std::vector<world::Obstacle> obstacles = cell.scene.obstacles;
  for (world::Obstacle& obstacle : obstacles) obstacle.X_WO = config::initial_pose(obstacle);
  return obstacles;
}

std::vector<double> joined(const std::vector<int>& arms, const std::vector<JointVector>& configuration) {
  std::vector<double> values;
  for (const int arm : arms) values.insert(values.end(), configuration[arm].begin(), configuration[arm].end());
  return values;
}

}  // namespace

CellModel::CellModel(const std::string& path) : file_(config::load_cell_file(path)) {}

std::vector<config::Finding> CellModel::check() const {
  std::vector<config::Finding> findings = config::validate(file_);
  for (const std::string& note : file_.notes) findings.push_back({config::Severity::kNote, note});
  return findings;
}

int CellModel::index(const std::string& arm) const {
  const auto& arms = file_.cell.arms;
  const auto found =
      std::find_if(arms.begin(), arms.end(), [&](const auto& planned) { return planned.arm.name == arm; });
  if (found != arms.end()) return static_cast<int>(found - arms.begin());
  std::string names;
  for (const auto& planned : arms) names += (names.empty() ? "" : ", ") + planned.arm.name;
  throw UnknownName("'" + arm + "' is no arm of the cell; its arms are " + names, arm);
}

const planner::PlannedArm& CellModel::arm(const std::string& name) const {
  return file_.cell.arms[index(name)];
}

JointVector CellModel::start(const std::string& name) const {
  const planner::PlannedArm& planned = arm(name);
  return planned.start.size() > 0 ? planned.start : planned.arm.home();
}

JointVector CellModel::joints(int arm, const std::vector<double>& q) const {
  const planner::Arm& planned = file_.cell.arms[arm].arm;
  const int expected = planned.model->joints();
  if (q.size() != static_cast<std::size_t>(expected)) {
    throw InvalidArgument("arm " + planned.name + " has " + std::to_string(expected) + " joints, not " +
                          std::to_string(q.size()));
  }
  if (!std::all_of(q.begin(), q.end(), [](double value) { return std::isfinite(value); })) {
    throw InvalidArgument("joint positions of arm " + planned.name + " must be finite");
  }
  return Eigen::Map<const Eigen::VectorXd>(q.data(), expected);
}

planner::Kinematics CellModel::forward(const std::string& name, const std::vector<double>& q) const {
  const planner::Arm& own = arm(name).arm;
  planner::Kinematics kinematics;
  planner::forward_kinematics(*own.model, own.X_WB, joints(index(name), q), kinematics);
  return kinematics;
}

planner::FrameJacobian CellModel::jacobian(const std::string& name, const std::vector<double>& q) const {
  planner::FrameJacobian J;
  planner::tool_jacobian(*arm(name).arm.model, forward(name, q), J);
  return J;
}

std::optional<JointVector> CellModel::inverse(const std::string& name, const planner::Pose& X_WT,
                                              const InverseQuery& query, const std::stop_token& stop) const {
  const int own = index(name);
  planner::IkOptions options;
  options.free_rotation = query.free_rotation;
  options.position_tolerance = query.position_tolerance;
  options.orientation_tolerance = query.orientation_tolerance;
  std::optional<planner::CellGeometry> geometry;
  std::vector<world::ObstacleState> states;
  if (query.collision_free) {
    const std::vector<world::Obstacle> obstacles = obstacles_at_begin(file_.cell);
    geometry.emplace(planner::arms_of(file_.cell), own);
    geometry->set_obstacles(obstacles);
    for (const world::Obstacle& obstacle : obstacles) {
      states.emplace_back().X_WO = obstacle.X_WO;
    }
    options.accept = [&](const JointVector& q) { return !planner::reject_goal(*geometry, q, states); };
  }
  const JointVector from = query.start ? joints(own, *query.start) : start(name);
  // In parts of some tenths of a second, so that a stop ends it. Each part has random configurations of its own.
  constexpr int kPart = 32;
  for (std::int64_t left = query.seeds;; left -= kPart, ++options.random_seed) {
    options.seeds = static_cast<int>(std::min<std::int64_t>(left, kPart));
    const auto q = planner::inverse_kinematics(file_.cell.arms[own].arm, X_WT, from, options);
    if (q || left <= kPart || stop.stop_requested()) return q;
  }
}

std::vector<JointVector> CellModel::configuration(const Positions& positions) const {
  std::vector<JointVector> all;
  for (const planner::PlannedArm& planned : file_.cell.arms) all.push_back(start(planned.arm.name));
  for (const auto& [name, q] : positions) all[index(name)] = joints(index(name), q);
  return all;
}

global::Validity CellModel::validity(const std::vector<int>& planned, std::vector<JointVector> others,
                                     double clearance) const {
  const std::vector<world::Obstacle> obstacles = obstacles_at_begin(file_.cell);
  std::vector<planner::CellGeometry> geometries;
  for (const int arm : planned) {
    geometries.emplace_back(planner::arms_of(file_.cell), arm).set_obstacles(obstacles);
    others[arm] = JointVector();
  }
  std::vector<world::Pose> X_WO;
  for (const world::Obstacle& obstacle : obstacles) X_WO.push_back(obstacle.X_WO);
  const auto bodies = global::world_bodies(geometries.front(), X_WO, others);
  global::ValidityOptions options;
  options.step = kJointStep;
  options.padding = clearance;
  return {std::move(geometries), bodies, options};
}

global::Validity::Nearest CellModel::nearest(const Positions& positions) const {
  std::vector<int> all(file_.cell.arms.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<JointVector> q = configuration(positions);
  return validity(all, q, 0.0).nearest(joined(all, q));
}

PlanAnswer CellModel::plan(const PlanQuery& query, const std::stop_token& stop) const {
  if (query.goal.empty()) throw InvalidArgument("a plan needs the goal of at least one arm");
  std::vector<int> arms;
  for (const auto& [name, q] : query.goal) arms.push_back(index(name));
  std::sort(arms.begin(), arms.end());
  const std::vector<JointVector> from = configuration(query.start);
  const std::vector<JointVector> to = configuration(query.goal);
  const global::Validity checks = validity(arms, from, query.clearance);

  global::PlanOptions options;
  if (query.method) options.planner = global::built_in_planners().at(*query.method);
  options.seed = query.seed;
  options.shortcuts.clearance = kKeptClearance;
  const auto end = Clock::now() + std::chrono::duration<double>(query.budget);
  options.budget.ended = [&] { return stop.stop_requested() || Clock::now() > end; };

  PlanAnswer answer;
  for (const int arm : arms) {
    answer.arms.push_back(file_.cell.arms[arm].arm.name);
    answer.joints.push_back(file_.cell.arms[arm].arm.model->joints());
  }
  answer.plan = global::plan(checks, joined(arms, from), joined(arms, to), options);
  const auto& path = answer.plan.path;
  for (std::size_t i = 1; i < path.size(); ++i) {
    answer.clearance =
        std::min(answer.clearance, checks.clearance(path[i - 1], path[i], global::Validity::Pairs::kNotOwn));
  }
  if (!answer.plan.solved() || stop.stop_requested()) return answer;
  global::TimedPathOptions timing;
  timing.clearance = std::clamp(0.9 * (answer.clearance - query.clearance), 0.0, kKeptClearance);
  answer.trajectory = planner::AveragedTrajectory(global::timed_path(checks, answer.plan.path, timing));
  return answer;
}

planner::BatchReport CellModel::simulate(int tasks, std::uint64_t seed, int threads,
                                         const std::stop_token& stop) const {
  planner::BatchOptions options;
  options.tasks = tasks;
  options.seed = seed;
  options.threads = threads;
  options.ended = [&stop] { return stop.stop_requested(); };
  planner::BatchReport report = planner::simulate_tasks(file_.cell, options);
  if (report.tasks == 0 && !report.ended_early)
    throw InvalidArgument(file_.path + ": tasks: " + report.failure.value_or("none was asked for"));
  return report;
}

}  // namespace hecaton::python
