#include "planner/arm_planner/arm_planner.hpp"

#include <algorithm>
#include <utility>

namespace hecaton::planner {
namespace {

/// The rest of a trajectory in steps of kWayStep, or in kMostSteps longer ones.
std::vector<JointVector> rest_of(const TrajectoryTracking& tracking) {
  constexpr double kWayStep = 0.1;  // [s]
  constexpr double kMostSteps = 48;
  const double left = std::max(0.0, tracking.trajectory->duration() - tracking.time);
  const double step = std::max(kWayStep, left / kMostSteps);
  std::vector<JointVector> points;
  for (double ahead = step; ahead < left; ahead += step) points.push_back(tracking.at(tracking.time + ahead).q);
  points.push_back(tracking.trajectory->end());
  return points;
}

}  // namespace

ArmPlanner::ArmPlanner(CellGeometry geometry, const LocalParameters& parameters, const ArmPlannerOptions& options)
    : controller_(std::move(geometry), parameters, options.control_period, options.motion_seed),
      rollouts_(parameters, options.rollout_seed),
      routes_(parameters, options.route_seed),
      coordinator_(parameters, options.route_seed, options.plan_numbers_after) {}

void ArmPlanner::receive(const PeriodEvents& events) {
  if (events.missed > 0.0) controller_.skip(events.missed);
  if (events.drops_setpoint) controller_.forget_setpoint();
  if (events.obstacles) controller_.set_obstacles(*events.obstacles);
  if (events.goal && events.goal->q_goal)
    controller_.set_goal(*events.goal->q_goal, events.goal->trajectory, events.goal->trajectory_time);
  if (events.goal && !events.goal->q_goal) controller_.cancel_goal();
  for (const RangeScan& scan : events.scans) controller_.sense(scan);
}

TickResult ArmPlanner::step(const PeriodInputs& inputs) {
  if (const auto time = rollouts_.rollout_wait()) controller_.wait_for_rollout(*time);
  controller_.order_speed(inputs.speed);
  TickResult result = controller_.step(inputs.own, inputs.arms, inputs.obstacles, inputs.hold);
  if (inputs.number > 0) controller_.sent(inputs.number);
  return result;
}

SearchQuestions ArmPlanner::plan_ahead(const PeriodInputs& inputs, const TickResult& result) {
  const auto& [rollout, route, coupled_plan] = inputs.answers;
  SearchQuestions questions;
  if (inputs.commands) questions.rollout = rollouts_.next(controller_, result, inputs.arms, inputs.obstacles);
  if (rollout) {
    rollouts_.answered();
    if (inputs.commands) controller_.begin(rollout->manoeuvre);
    ++rollout_answers_;
  }

  if (!inputs.commands) coordinator_.withdraw();
  if (coupled_plan) coordinator_.receive(*coupled_plan);
  if (inputs.commands) questions.coupled_plan = coordinator_.next(controller_, result, inputs.arms, inputs.obstacles);
  if (coordinator_.target()) {
    controller_.follow_coupled_plan(*coordinator_.target());
  } else {
    controller_.leave_coupled_plan();
  }

  // An arm that follows a coupled plan has no route of its own.
  const bool routed = inputs.commands && !coordinator_.participating();
  if (!routed) routes_.discard();
  if (route) {
    if (auto points = routes_.receive(*route, controller_)) controller_.follow(std::move(*points));
  }
  if (routed) {
    RoutePolicy::Next next = routes_.next(controller_, result, inputs.arms, inputs.obstacles);
    if (next.leaves_route) controller_.follow({});
    questions.route = std::move(next.question);
  }
  return questions;
}

std::vector<JointVector> ArmPlanner::way() const {
  if (coordinator_.participating()) return coordinator_.left();
  if (!controller_.has_goal()) return {};
  const auto route = controller_.route().left();
  if (!route.empty()) return {route.begin(), route.end()};
  if (controller_.tracks()) return rest_of(controller_.memory().tracking);
  return {*controller_.goal()};
}

void ArmPlanner::describe(MemoryArchive& archive) {
  archive(controller_, rollouts_, routes_, coordinator_);
  archive.count(rollout_answers_);
}

std::vector<std::uint32_t> ArmPlanner::save() const {
  MemoryArchive archive;
  const_cast<ArmPlanner*>(this)->describe(archive);  // an archive that saves changes nothing
  return archive.good() ? archive.take_words() : std::vector<std::uint32_t>();
}

bool ArmPlanner::restore(std::span<const std::uint32_t> words) {
  const CellGeometry& geometry = controller_.geometry();
  MemoryArchive archive(words, static_cast<int>(geometry.arms().size()), geometry.own_arm().model->joints());
  describe(archive);
  return archive.complete();
}

}  // namespace hecaton::planner
