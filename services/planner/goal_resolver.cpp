#include "services/planner/goal_resolver.hpp"

#include <cmath>
#include <iomanip>
#include <sstream>
#include <utility>

#include "planner/goal_check.hpp"
#include "planner/model/arm.hpp"
#include "planner/model/inverse_kinematics.hpp"
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
    case planner::RejectionKind::kInCollision:
      break;
  }
  return CauseKind::CAUSE_GOAL_IN_COLLISION;
}

GoalAnswer checked(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_goal,
                   std::span<const world::ObstacleState> obstacles) {
  const auto rejection = planner::reject_goal(geometry, q_goal, obstacles);
  if (rejection) return rejected(goal, kind_of(rejection->kind), rejection->text, rejection->subject);
  return {.goal = goal, .q_goal = q_goal};
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

planner::IkTask ik_task(int joints) {
  if (joints >= 6) return planner::IkTask::kPose;
  return joints == 5 ? planner::IkTask::kPositionAndAxis : planner::IkTask::kPosition;
}

GoalAnswer pose_goal(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_now,
                     std::span<const world::ObstacleState> obstacles) {
  const planner::Arm& arm = geometry.own_arm();
  const auto X_WT = messages::from_message(goal.X_WT(), "goal: pose");
  if (!X_WT) return rejected(goal, CauseKind::CAUSE_GOAL_MALFORMED, X_WT.error);
  const Eigen::Vector3d p_WT = X_WT->translation();
  std::ostringstream out;
  out << std::setprecision(3) << "the tool of arm " << arm.name << " cannot be at (" << p_WT.x() << ", " << p_WT.y()
      << ", " << p_WT.z() << ")";
  const planner::ArmReach reach = planner::arm_reach(arm);
  if (const double away = (p_WT - reach.centre).norm(); away > reach.tool) {
    out << ": that is " << away << " m from its first joint, and it reaches no farther than " << reach.tool << " m";
    return rejected(goal, CauseKind::CAUSE_GOAL_UNREACHABLE, out.str(), arm.name);
  }

  std::optional<planner::Rejection> last;
  int reaching = 0;
  planner::IkOptions options;
  options.task = ik_task(arm.model->joints());
  options.accept = [&](const JointVector& q) {
    ++reaching;
    last = planner::reject_goal(geometry, q, obstacles);
    return !last;
  };
  const auto solution = planner::inverse_kinematics(arm, *X_WT, q_now, options);
  if (solution) return checked(geometry, goal, *solution, obstacles);
  if (!last) {
    out << " in that orientation: no joint positions within the limits were found, from " << options.seeds + 1
        << " postures";
    return rejected(goal, CauseKind::CAUSE_GOAL_UNREACHABLE, out.str(), arm.name);
  }
  out << ": none of " << reaching << " joint positions found there is free; the last: " << last->text;
  return rejected(goal, kind_of(last->kind), out.str(), last->subject);
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
