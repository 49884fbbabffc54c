#include "services/planner/goal_resolver.hpp"

#include <cmath>
#include <utility>

#include "planner/goal_check.hpp"
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
                     std::span<const world::ObstacleState> obstacles) {
  const auto tool = messages::from_message(goal.tool(), "goal: tool");
  if (!tool) return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED, tool.error);
  const planner::ToolGoalAnswer found =
      planner::resolve_tool_goal(geometry.own_arm(), *tool, q_now,
                                 [&](const JointVector& q) { return planner::reject_goal(geometry, q, obstacles); });
  if (!found.rejection) return {.goal = goal, .q_goal = found.q, .tool = *tool};
  GoalAnswer answer = rejected(goal, *found.rejection);
  answer.nearest = found.nearest;
  return answer;
}

}  // namespace

GoalAnswer resolve_goal(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_now,
                        std::span<const world::ObstacleState> obstacles) {
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
      return pose_goal(geometry, goal, q_now, obstacles);
  }
  return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED, "goal: unknown kind");
}

struct GoalResolver::Impl {
  using Thread = BackgroundThread<GoalQuestion, GoalAnswer>;

  explicit Impl(planner::CellGeometry cell)
      : geometry(std::move(cell)), thread([this](auto question) {
          const GoalQuestion& asked = question.value();  // each turn has a question
          geometry.set_obstacles(*asked.obstacles);
          return Thread::Turn{resolve_goal(geometry, asked.goal, asked.q_now, asked.states)};
        }) {}

  planner::CellGeometry geometry;  ///< of the thread alone
  Thread thread;
};

GoalResolver::GoalResolver(planner::CellGeometry geometry) : impl_(std::make_unique<Impl>(std::move(geometry))) {}
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
