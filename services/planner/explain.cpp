#include "services/planner/explain.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "planner/local/goal_objective.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

using msg::CauseKind;

/// Without fresh states this long the goal counts as blocked [s]; shorter gaps are normal on a network.
constexpr double kBlockedAfter = 1.0;
/// The measured arm may be this much farther from the goal than its set-point: the drive's tracking error.
constexpr double kTrackingTolerance = 2.0;

std::string milliseconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f ms", seconds * 1e3);
  return text;
}

msg::Cause stale(const planner::TickResult& result, const planner::CellGeometry& geometry,
                 std::span<const planner::ArmObservation> arms, std::span<const world::ObstacleState> obstacles) {
  if (result.stale_arm < 0) {
    double age = 0.0;
    for (const auto& obstacle : obstacles) age = std::max(age, obstacle.age);
    return make_cause(CauseKind::CAUSE_OBSTACLES_OLD, world_node(),
                      "the last states of the obstacles are " + milliseconds(age) + " old");
  }
  const std::string& name = geometry.arms()[result.stale_arm].name;
  const planner::ArmObservation& arm = arms[result.stale_arm];
  return make_cause(CauseKind::CAUSE_ARM_STATE_OLD, name,
                    arm.known ? "the last state of arm " + name + " is " + milliseconds(arm.age) + " old"
                              : "the state of arm " + name + " was never heard");
}

/// The lost arm that is in the way, or may be: the one that binds, or when no pair binds, any. −1: none.
int lost_arm(const planner::TickResult& result, std::span<const planner::ArmObservation> arms) {
  const bool of_an_arm = result.has_binding && result.binding.counterpart == planner::Counterpart::kArm;
  if (of_an_arm && arms[result.binding.other].lost()) return result.binding.other;
  if (result.has_binding || result.status != planner::TickStatus::kBlocked) return -1;
  const auto found = std::find_if(arms.begin(), arms.end(), [](const auto& arm) { return arm.lost(); });
  return found == arms.end() ? -1 : static_cast<int>(found - arms.begin());
}

std::string what_binds(const Progress& progress) {
  if (!progress.has_binding) return {};
  char distance[32];
  std::snprintf(distance, sizeof distance, "%.0f mm", progress.binding_distance * 1e3);
  return ": " + progress.binding_own + " – " + progress.binding_other + ", " + distance;
}

std::string subspaces(int redraws) {
  return redraws <= 0 ? "" : ", in subspace " + std::to_string(redraws);
}

}  // namespace

Progress explain(const planner::TickResult& result, const planner::Approach& approach,
                 const planner::CellGeometry& geometry, std::span<const planner::ArmObservation> arms,
                 std::span<const world::ObstacleState> obstacles, const std::optional<msg::Cause>& hold) {
  const std::string& own = geometry.own_arm().name;
  Progress progress;
  progress.held_back = true;
  if (result.has_binding) {
    progress.has_binding = true;
    progress.binding_own = geometry.own_name(result.binding);
    progress.binding_other = geometry.other_name(result.binding);
    progress.binding_distance = result.binding.distance;
  }
  switch (result.status) {
    case planner::TickStatus::kBlocked: {
      progress.state = msg::GoalState::GOAL_BLOCKED;
      progress.cause =
          make_cause(CauseKind::CAUSE_WAY_BLOCKED, progress.binding_other, "no progress" + what_binds(progress));
      progress.recovery_action = "looks for a way along the boundary" + subspaces(result.redraws);
      break;
    }
    case planner::TickStatus::kFollowing:
      if (!result.has_binding) {
        progress.cause = make_cause(CauseKind::CAUSE_AT_JOINT_LIMITS, own, "at its joint limits");
      }
      progress.recovery_action = "follows the boundary" + subspaces(result.redraws);
      break;
    case planner::TickStatus::kDetouring:
      progress.recovery_action = "makes a detour";
      break;
    case planner::TickStatus::kTogether:
      progress.recovery_action = "goes by a plan for all arms that stand in each other's way";
      break;
    case planner::TickStatus::kRouted:
      progress.held_back = result.has_binding || approach.hopeless();
      progress.recovery_action = "goes by a route around what stands in its way";
      break;
    case planner::TickStatus::kYielding:
      progress.recovery_action = "makes room for arm " + geometry.arms()[result.yields_to].name;
      progress.cause = make_cause(CauseKind::CAUSE_GIVING_WAY, geometry.arms()[result.yields_to].name,
                                  "arm " + geometry.arms()[result.yields_to].name + " has the right of way");
      break;
    case planner::TickStatus::kHolding:
      progress.held_back = false;  // a person or a fault holds the arm, not a body in its way
      if (hold) progress.cause = *hold;
      progress.recovery_action = "waits";
      break;
    case planner::TickStatus::kStaleInput:
      progress.cause = stale(result, geometry, arms, obstacles);
      progress.recovery_action = "waits for fresh states";
      break;
    case planner::TickStatus::kIdle:
    case planner::TickStatus::kReached:
      progress.held_back = false;
      break;
    case planner::TickStatus::kMoving:
      // A free stretch in the midst of a search ends nothing yet.
      progress.held_back = result.has_binding || approach.hopeless();
      progress.recovery_action =
          result.has_binding ? "goes straight to the goal as far as it is let" : "goes straight to the goal";
      break;
  }
  if (progress.held_back && progress.state == msg::GoalState::GOAL_ACTIVE && approach.hopeless()) {
    progress.state = msg::GoalState::GOAL_BLOCKED;
    char text[64];
    std::snprintf(text, sizeof text, "no way found for %.0f s", approach.lost());
    progress.cause = make_cause(CauseKind::CAUSE_WAY_BLOCKED, progress.binding_other, text + what_binds(progress));
  }
  if (const int lost = lost_arm(result, arms); lost >= 0) {
    const std::string& name = geometry.arms()[lost].name;
    const std::string before = is_none(progress.cause) ? "" : progress.cause.text() + "; ";
    progress.cause =
        make_cause(CauseKind::CAUSE_WAY_BLOCKED, name, before + "arm " + name + " was lost and may be nearer");
  } else if (result.status == planner::TickStatus::kBlocked && !result.has_binding) {
    progress.cause.text(progress.cause.text() + " within the joint limits");
  }
  return progress;
}

std::optional<Progress> ProgressReporter::report(const Period& period) {
  const planner::ArmController& controller = period.planner.planner().controller();
  const bool missing_input = period.hold && is_missing_input(*period.hold);
  const bool starved =
      missing_input || (period.planned && period.planned->result.status == planner::TickStatus::kStaleInput);
  starved_ = starved ? starved_ + controller.control_period() : 0.0;
  if (period.q_goal == nullptr) return std::nullopt;

  Progress progress;
  if (period.planned) {
    const auto& [inputs, result] = *period.planned;
    const ArmView::Heard& own = *period.planner.own_arm();
    progress =
        explain(result, controller.approach(), controller.geometry(), inputs.arms, inputs.obstacles, period.hold);
    const bool blocked = result.status == planner::TickStatus::kBlocked && !result.has_binding;
    if (blocked && controller.guide() != nullptr) {
      if (auto why = controller.guide()->why_none(own.q)) progress.cause.text(std::move(*why));
      progress.recovery_action = "stays until it sees a way";
    }
    if (period.planner.planner().looks_ahead()) progress.recovery_action += ", looks ahead";
    const planner::JointVector to_go =
        planner::joint_difference(controller.geometry().own_arm().limits, own.q, *period.q_goal);
    progress.distance = to_go.norm();
    const bool there = to_go.cwiseAbs().maxCoeff() < kTrackingTolerance * controller.parameters().goal_tolerance;
    if (result.status == planner::TickStatus::kReached && there) progress.state = msg::GoalState::GOAL_REACHED;
    // An arm that has just started has had no command to follow.
    const bool follows = is_none(own.cause) || own.cause.kind() == CauseKind::CAUSE_STARTING;
    if (!follows && !period.hold && !starved) {
      progress.cause = make_cause(CauseKind::CAUSE_DEVICE_DOES_NOT_FOLLOW, period.planner.name(),
                                  "the drive does not follow: " + own.cause.text());
    }
  } else {
    if (period.hold) progress.cause = *period.hold;
    progress.recovery_action = "waits for the driver";
    progress.held_back = true;
  }
  progress.priority = controller.claim();
  if (progress.state == msg::GoalState::GOAL_ACTIVE && starved_ > kBlockedAfter) {
    progress.state = msg::GoalState::GOAL_BLOCKED;
  }
  return progress;
}

}  // namespace hecaton::services
