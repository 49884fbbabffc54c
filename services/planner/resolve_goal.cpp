#include "services/planner/resolve_goal.hpp"

#include <cmath>
#include <iomanip>
#include <sstream>

#include "planner/goal_check.hpp"
#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/reach.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services {
namespace {

using planner::JointVector;

GoalAnswer rejected(const msg::Goal& goal, std::string reason) {
  GoalAnswer answer;
  answer.goal = goal;
  answer.reason = std::move(reason);
  return answer;
}

GoalAnswer checked(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_goal,
                   std::span<const world::ObstacleState> obstacles) {
  std::string reason = planner::reject_goal(geometry, q_goal, obstacles);
  if (!reason.empty()) return rejected(goal, std::move(reason));
  GoalAnswer answer;
  answer.goal = goal;
  answer.accepted = true;
  answer.q_goal = q_goal;
  return answer;
}

// Unlike messages::joints_from_message this lets any finite or infinite number pass: the check knows the joints' names.
GoalAnswer joint_goal(const planner::CellGeometry& geometry, const msg::Goal& goal,
                      std::span<const world::ObstacleState> obstacles) {
  const planner::Arm& arm = geometry.own_arm();
  if (goal.q().size() != static_cast<std::size_t>(arm.model->joints())) {
    return rejected(goal, "goal has " + std::to_string(goal.q().size()) + " joint values, arm " + arm.name + " has " +
                              std::to_string(arm.model->joints()) + " joints");
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
  return rejected(goal, "arm " + arm.name + " has no pose named \"" + goal.named() + "\"; it has " + names);
}

planner::IkTask ik_task(int joints) {
  if (joints >= 6) return planner::IkTask::kPose;
  return joints == 5 ? planner::IkTask::kPositionAndAxis : planner::IkTask::kPosition;
}

GoalAnswer pose_goal(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_now,
                     std::span<const world::ObstacleState> obstacles) {
  const planner::Arm& arm = geometry.own_arm();
  const auto X_WT = messages::from_message(goal.X_WT(), "goal: pose");
  if (!X_WT) return rejected(goal, X_WT.error);
  const Eigen::Vector3d p_WT = X_WT->translation();
  std::ostringstream out;
  out << std::setprecision(3) << "the tool of arm " << arm.name << " cannot be at (" << p_WT.x() << ", " << p_WT.y()
      << ", " << p_WT.z() << ")";
  const planner::ArmReach reach = planner::arm_reach(arm);
  if (const double away = (p_WT - reach.centre).norm(); away > reach.tool) {
    out << ": that is " << away << " m from its first joint, and it reaches no farther than " << reach.tool << " m";
    return rejected(goal, out.str());
  }

  std::string last_reason;
  int reaching = 0;
  planner::IkOptions options;
  options.task = ik_task(arm.model->joints());
  options.accept = [&](const JointVector& q) {
    ++reaching;
    last_reason = planner::reject_goal(geometry, q, obstacles);
    return last_reason.empty();
  };
  const auto solution = planner::inverse_kinematics(arm, *X_WT, q_now, options);
  if (solution) return checked(geometry, goal, *solution, obstacles);
  if (reaching == 0) {
    out << " in that orientation: no joint positions within the limits were found, from " << options.seeds + 1
        << " postures";
  } else {
    out << ": none of " << reaching << " joint positions found there is free; the last: " << last_reason;
  }
  return rejected(goal, out.str());
}

}  // namespace

GoalAnswer resolve_goal(const planner::CellGeometry& geometry, const msg::Goal& goal, const JointVector& q_now,
                        std::span<const world::ObstacleState> obstacles) {
  if (!std::isfinite(goal.time_limit()) || goal.time_limit() < 0.0) {
    return rejected(goal, "goal: time_limit = " + std::to_string(goal.time_limit()) + " must be 0 (none) or above [s]");
  }
  switch (goal.kind()) {
    case msg::GoalKind::GOAL_JOINTS:
      return joint_goal(geometry, goal, obstacles);
    case msg::GoalKind::GOAL_NAMED:
      return named_goal(geometry, goal, obstacles);
    case msg::GoalKind::GOAL_POSE:
      return pose_goal(geometry, goal, q_now, obstacles);
  }
  return rejected(goal, "goal: unknown kind");
}

}  // namespace hecaton::services
