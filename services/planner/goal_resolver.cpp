#include "services/planner/goal_resolver.hpp"

#include <cmath>
#include <utility>

#include "planner/goal_check.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/model/arm.hpp"
#include "services/messages/convert.hpp"
#include "services/planner/background_thread.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {
namespace {

using planner::JointVector;

using msg::CauseKind;

GoalAnswer rejected(const msg::Goal& goal, CauseKind kind, std::string text, std::string subject = {}) {
  return {.goal = goal, .rejection = make_cause(kind, std::move(subject), std::move(text))};
}

CauseKind kind_of(planner::RejectionKind kind) {
  switch (kind) {
    case planner::RejectionKind::kMalformed:
      return CauseKind::CAUSE_GOAL_MALFORMED;
    case planner::RejectionKind::kOutsideLimits:
      return CauseKind::CAUSE_GOAL_OUTSIDE_LIMITS;
    case planner::RejectionKind::kUnreachable:
      return CauseKind::CAUSE_GOAL_UNREACHABLE;
    case planner::RejectionKind::kOrientation:
      return CauseKind::CAUSE_GOAL_ORIENTATION;
    case planner::RejectionKind::kInCollision:
      break;
  }
  return CauseKind::CAUSE_GOAL_IN_COLLISION;
}

GoalAnswer rejected(const msg::Goal& goal, const planner::Rejection& rejection) {
  return rejected(goal, kind_of(rejection.kind), rejection.text, rejection.subject);
}

GoalAnswer checked(const planner::CellGeometry& geometry, const msg::Goal& goal, JointVector q_goal,
                   std::span<const world::ObstacleState> obstacles) {
  std::string note = planner::clamp_rounding(geometry.own_arm(), q_goal);
  if (const auto rejection = planner::reject_goal(geometry, q_goal, obstacles)) return rejected(goal, *rejection);
  return {.goal = goal, .q_goal = q_goal, .note = std::move(note)};
}

// Accepts any number, unlike messages::joints_from_message: the check names the joint that is out of limits.
GoalAnswer joint_goal(const planner::CellGeometry& geometry, const msg::Goal& goal,
                      std::span<const world::ObstacleState> obstacles) {
  const planner::Arm& arm = geometry.own_arm();
  if (goal.q().size() != static_cast<std::size_t>(arm.model->joints())) {
    return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED,
                    "goal has " + std::to_string(goal.q().size()) + " joint values, arm " + arm.name + " has " +
                        std::to_string(arm.model->joints()) + " joints",
                    arm.name);
  }
  const JointVector q = Eigen::Map<const Eigen::VectorXd>(goal.q().data(), static_cast<Eigen::Index>(goal.q().size()));
  return checked(geometry, goal, q, obstacles);
}

GoalAnswer named_goal(const planner::CellGeometry& geometry, const msg::Goal& goal,
                      std::span<const world::ObstacleState> obstacles) {
  const planner::Arm& arm = geometry.own_arm();
  if (const auto pose = arm.named.find(goal.named()); pose != arm.named.end()) {
    return checked(geometry, goal, pose->second, obstacles);
  }
  std::string names;
  for (const auto& [name, q] : arm.named) names += (names.empty() ? "" : ", ") + name;
  return rejected(goal, CauseKind::CAUSE_UNKNOWN_NAME,
                  "arm " + arm.name + " has no pose named \"" + goal.named() + "\"; it has " + names, goal.named());
}

GoalAnswer pose_goal(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_now,
                     std::span<const world::ObstacleState> obstacles, double self_security_distance) {
  const auto tool = messages::from_message(goal.tool(), "goal: tool");
  if (!tool) return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED, tool.error);
  const planner::ToolGoalAnswer found = planner::resolve_tool_goal(
      geometry.own_arm(), *tool, q_now,
      [&](const JointVector& q) { return planner::reject_goal(geometry, q, obstacles); },
      [&](const JointVector& q) { return planner::reject_goal(geometry, q, obstacles, self_security_distance); });
  if (!found.rejection) return {.goal = goal, .q_goal = found.q, .tool = *tool};
  GoalAnswer answer = rejected(goal, *found.rejection);
  answer.nearest = found.nearest;
  return answer;
}

GoalAnswer trajectory_goal(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_now,
                           std::span<const world::ObstacleState> obstacles, bool begins) {
  const planner::Arm& arm = geometry.own_arm();
  auto converted = messages::from_message(goal.trajectory(), "goal: trajectory", arm.model->joints());
  if (!converted) return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED, converted.error, arm.name);
  planner::TimedTrajectory& trajectory = *converted.value;
  if (auto why = planner::objection(trajectory, arm.limits, arm.model->joint_names)) {
    return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED, std::move(*why), arm.name);
  }
  const planner::TimedPoint& first = trajectory.points.front();
  Eigen::Index farthest = 0;
  const double away = planner::joint_difference(arm.limits, q_now, first.q).cwiseAbs().maxCoeff(&farthest);
  if (begins && first.time == 0.0 && away > kTrajectoryStart) {
    const std::string& joint = arm.model->joint_names[static_cast<std::size_t>(farthest)];
    return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED,
                    "the trajectory begins " + std::to_string(away) + " from the measured position of joint " + joint +
                        " (limit " + std::to_string(kTrajectoryStart) + ")",
                    joint);
  }
  GoalAnswer answer = checked(geometry, goal, trajectory.end(), obstacles);
  if (answer.rejection) return answer;
  trajectory.points.back().q = answer.q_goal;  // the end may have been moved onto a limit
  answer.trajectory = std::make_shared<const planner::TimedTrajectory>(std::move(trajectory));
  return answer;
}

}  // namespace

GoalAnswer resolve_goal(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_now,
                        std::span<const world::ObstacleState> obstacles, bool begins, double self_security_distance) {
  if (!std::isfinite(goal.time_limit()) || goal.time_limit() < 0.0) {
    return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED,
                    "goal: time_limit = " + std::to_string(goal.time_limit()) + " must be 0 (none) or above [s]");
  }
  switch (goal.kind()) {
    case msg::GoalKind::GOAL_JOINTS:
      return joint_goal(geometry, goal, obstacles);
    case msg::GoalKind::GOAL_NAMED:
      return named_goal(geometry, goal, obstacles);
    case msg::GoalKind::GOAL_POSE:
      return pose_goal(geometry, goal, q_now, obstacles, self_security_distance);
    case msg::GoalKind::GOAL_TRAJECTORY:
      return trajectory_goal(geometry, goal, q_now, obstacles, begins);
  }
  return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED, "goal: unknown kind");
}

struct GoalResolver::Impl {
  using Thread = BackgroundThread<GoalQuestion, GoalAnswer>;

  explicit Impl(planner::CellGeometry cell, double self_security_distance)
      : geometry(std::move(cell)), thread([this, self_security_distance](auto question) {
          const GoalQuestion& asked = question.value();  // each turn has a question
          geometry.set_obstacles(*asked.obstacles);
          if (asked.goal.kind() == msg::GoalKind::GOAL_TRAJECTORY && !asked.follows_trajectories) {
            const std::string& arm = geometry.own_arm().name;
            return Thread::Turn{rejected(asked.goal, CauseKind::CAUSE_GOAL_MALFORMED,
                                         "the motion method of arm " + arm + " follows no trajectories; send its end",
                                         arm)};
          }
          return Thread::Turn{
              resolve_goal(geometry, asked.goal, asked.q_now, asked.states, asked.begins, self_security_distance)};
        }) {}

  planner::CellGeometry geometry;  ///< of the thread alone
  Thread thread;
};

GoalResolver::GoalResolver(planner::CellGeometry geometry, double self_security_distance)
    : impl_(std::make_unique<Impl>(std::move(geometry), self_security_distance)) {}
GoalResolver::~GoalResolver() = default;

void GoalResolver::ask(GoalQuestion question) {
  impl_->thread.ask(std::move(question));
}

std::vector<GoalAnswer> GoalResolver::answers() {
  std::vector<GoalAnswer> all;
  while (auto answer = impl_->thread.answer()) all.push_back(std::move(*answer));
  return all;
}

ProgressWatchdog::Clock::duration GoalResolver::silence(ProgressWatchdog::Clock::time_point now) {
  return impl_->thread.silence(now);
}

}  // namespace hecaton::services
