#include "services/planner/progress_reporter.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "planner/goal_check.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/model/kinematics.hpp"
#include "services/planner/live_planner.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

using msg::CauseKind;

/// Time without fresh inputs after which the goal is blocked [s]. Shorter gaps are normal on a network.
constexpr double kBlockedAfter = 1.0;
/// Time for the drive to settle after its set-point has arrived at the goal [s].
constexpr double kSettleTime = 1.0;

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
                              : "no state of arm " + name + " has been received");
}

/// The lost arm that blocks the arm: that of the binding pair; without a binding pair any lost arm. −1: none.
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

constexpr double kNextTime = 0.5;  ///< of the point of a trajectory that other arms expect the arm at next [s]

/// The progress on a trajectory; empty: the arm has not begun one.
std::optional<Progress::Trajectory> on_trajectory(const planner::ArmController& controller,
                                                  const planner::JointVector& q, bool commands,
                                                  const Progress& progress) {
  const planner::TrajectoryTracking& tracking = controller.memory().tracking;
  if (!controller.goal() || !tracking.trajectory || !tracking.begun) return std::nullopt;
  Progress::Trajectory on{tracking.time, tracking.rate, *controller.goal()};
  if (tracking.follows()) on.q_next = tracking.at(tracking.time + kNextTime).q;
  const planner::Arm& arm = controller.geometry().own_arm();
  const int joint = commands ? planner::outside_path_tolerance(arm.limits, q, tracking) : -1;
  if (joint >= 0) {
    const std::string& name = arm.model->joint_names[static_cast<std::size_t>(joint)];
    char tolerance[32];
    std::snprintf(tolerance, sizeof tolerance, "%.4g", tracking.trajectory->path_tolerance[joint]);
    const std::string why = is_none(progress.cause) ? what_binds(progress) : ": " + progress.cause.text();
    on.left = make_cause(CauseKind::CAUSE_PATH_TOLERANCE, name,
                         "joint " + name + " is outside its path tolerance of " + tolerance + why);
  }
  return on;
}

std::string subspaces(int drawn) {
  return drawn <= 0 ? "" : ", in subspace " + std::to_string(drawn);
}

planner::ToolError measured_error(const planner::Arm& arm, const planner::JointVector& q,
                                  const planner::ToolGoal& goal) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
  return planner::tool_error(goal, kinematics.X_WT);
}

}  // namespace

Progress progress_of(const planner::TickResult& result, const planner::ProgressMonitor& goal_progress,
                     const planner::CellGeometry& geometry, std::span<const planner::ArmObservation> arms,
                     std::span<const world::ObstacleState> obstacles, const std::optional<msg::Cause>& hold) {
  const std::string& own = geometry.own_arm().name;
  Progress progress;
  progress.obstructed = true;
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
          make_cause(CauseKind::CAUSE_PATH_BLOCKED, progress.binding_other, "no progress" + what_binds(progress));
      progress.recovery_action = "searches a path along the boundary" + subspaces(result.subspaces_drawn);
      break;
    }
    case planner::TickStatus::kFollowingBoundary:
      if (!result.has_binding) {
        progress.cause = make_cause(CauseKind::CAUSE_AT_JOINT_LIMITS, own, "at its joint limits");
      }
      progress.recovery_action = "follows the boundary" + subspaces(result.subspaces_drawn);
      break;
    case planner::TickStatus::kDetouring:
      progress.recovery_action = "makes a detour";
      break;
    case planner::TickStatus::kFollowingPlan:
      progress.recovery_action = "follows a coupled plan with the other arms";
      break;
    case planner::TickStatus::kFollowingRoute:
      progress.obstructed = result.has_binding || goal_progress.stalled();
      progress.recovery_action = "follows a route around the obstacle";
      break;
    case planner::TickStatus::kYielding:
      progress.recovery_action = "yields to arm " + geometry.arms()[result.yields_to].name;
      progress.cause = make_cause(CauseKind::CAUSE_GIVING_WAY, geometry.arms()[result.yields_to].name,
                                  "arm " + geometry.arms()[result.yields_to].name + " has the right of way");
      break;
    case planner::TickStatus::kHolding:
      progress.obstructed = false;  // by an order or a fault, not by an obstacle
      if (hold) progress.cause = *hold;
      progress.recovery_action = "waits";
      break;
    case planner::TickStatus::kStaleInput:
      progress.cause = stale(result, geometry, arms, obstacles);
      progress.recovery_action = "waits for fresh states";
      break;
    case planner::TickStatus::kIdle:
    case planner::TickStatus::kReached:
      progress.obstructed = false;
      break;
    case planner::TickStatus::kMoving:
      // A short free motion during a search does not end it.
      progress.obstructed = result.has_binding || goal_progress.stalled();
      progress.recovery_action =
          result.has_binding ? "moves straight to the goal as far as constraints allow" : "moves straight to the goal";
      break;
  }
  if (progress.obstructed && progress.state == msg::GoalState::GOAL_ACTIVE && goal_progress.stalled()) {
    progress.state = msg::GoalState::GOAL_BLOCKED;
    char text[64];
    std::snprintf(text, sizeof text, "no path found for %.0f s", goal_progress.time_without_progress());
    progress.cause = make_cause(CauseKind::CAUSE_PATH_BLOCKED, progress.binding_other, text + what_binds(progress));
  }
  if (const int lost = lost_arm(result, arms); lost >= 0) {
    const std::string& name = geometry.arms()[lost].name;
    const std::string before = is_none(progress.cause) ? "" : progress.cause.text() + "; ";
    progress.cause =
        make_cause(CauseKind::CAUSE_PATH_BLOCKED, name, before + "arm " + name + " was lost and may be nearer");
  } else if (result.status == planner::TickStatus::kBlocked && !result.has_binding) {
    progress.cause.text(progress.cause.text() + " within the joint limits");
  }
  return progress;
}

void ArrivalCheck::judge(bool set_point_there, const std::optional<std::string>& error, const std::string& arm,
                         double dt, Progress& progress) {
  if (!set_point_there || !error) waited_ = 0.0;
  if (!set_point_there) return;
  if (!error) {
    progress.state = msg::GoalState::GOAL_REACHED;
    return;
  }
  waited_ += dt;
  if (waited_ <= kSettleTime) return;
  progress.state = msg::GoalState::GOAL_BLOCKED;
  progress.obstructed = true;
  progress.cause = make_cause(CauseKind::CAUSE_DEVICE_DOES_NOT_FOLLOW, arm, "the drive does not follow: " + *error);
}

void LastBinding::update(bool path_bound, Progress& progress) {
  if (progress.has_binding) {
    pair_ = {progress.binding_own, progress.binding_other, progress.binding_distance};
  } else if (!progress.obstructed) {
    pair_.reset();
  }
  if (!path_bound || progress.cause.kind() != CauseKind::CAUSE_AT_JOINT_LIMITS) return;
  if (!pair_) return progress.cause.text("at its joint limits, or those of its path tolerance");
  char distance[32];
  std::snprintf(distance, sizeof distance, "%.3f", pair_->distance);
  progress.cause =
      make_cause(CauseKind::CAUSE_PATH_BLOCKED, pair_->other,
                 "at the limits of its path tolerance: " + pair_->own + " was " + distance + " m from " + pair_->other);
}

std::optional<Progress> ProgressReporter::report(const Period& period) {
  const planner::ArmController& controller = period.planner.controller();
  const bool missing_input = period.hold && is_missing_input(*period.hold);
  const bool starved =
      missing_input || (period.planned && period.planned->result.status == planner::TickStatus::kStaleInput);
  starved_ = starved ? starved_ + controller.control_period() : 0.0;
  if (period.q_goal == nullptr) return std::nullopt;

  Progress progress;
  if (period.planned) {
    const auto& [inputs, result, q, drive] = *period.planned;
    progress = progress_of(result, controller.goal_progress(), controller.geometry(), inputs.arms, inputs.obstacles,
                           period.hold);
    last_binding_.update(controller.memory().tracking.is_bound(), progress);
    const bool blocked = result.status == planner::TickStatus::kBlocked && !result.has_binding;
    if (blocked && controller.guide() != nullptr) {
      if (auto why = controller.guide()->no_path_reason(q)) progress.cause.text(std::move(*why));
      progress.recovery_action = "waits for a path";
    }
    if (period.planner.awaiting_rollout()) {
      progress.recovery_action += progress.recovery_action.empty() ? "runs rollouts" : ", runs rollouts";
    }
    const planner::Arm& arm = controller.geometry().own_arm();
    progress.distance = planner::joint_difference(arm.limits, q, *period.q_goal).norm();
    if (period.tool != nullptr) progress.tool_error = measured_error(arm, q, *period.tool);
    const bool set_point_there = result.status == planner::TickStatus::kReached;
    const double tolerance = controller.parameters().goal_tolerance;
    arrival_.judge(
        set_point_there,
        set_point_there ? planner::error_at_goal(arm, q, *period.q_goal, tolerance, period.tool) : std::nullopt,
        arm.name, controller.control_period(), progress);
    // A driver that has just started has received no command.
    const bool follows = is_none(drive) || drive.kind() == CauseKind::CAUSE_STARTING;
    if (!follows && !period.hold && !starved) {
      progress.cause =
          make_cause(CauseKind::CAUSE_DEVICE_DOES_NOT_FOLLOW, arm.name, "the drive does not follow: " + drive.text());
    }
  } else {
    if (period.hold) progress.cause = *period.hold;
    progress.recovery_action = "waits for the driver";
    progress.obstructed = true;
  }
  if (period.planned) {
    const planner::TrajectoryTracking& tracking = controller.memory().tracking;
    if (tracking.follows() && progress.state == msg::GoalState::GOAL_ACTIVE &&
        period.planned->result.status == planner::TickStatus::kMoving) {
      progress.recovery_action = "follows the trajectory as far as constraints allow";
    }
    if (tracking.follows() && period.planned->result.status == planner::TickStatus::kBlocked) {
      progress.recovery_action = "waits on its trajectory";
    }
    if (tracking.phase == planner::TrackingPhase::kAround) {
      progress.recovery_action = "goes around within the path tolerance of its trajectory";
    }
    progress.trajectory = on_trajectory(controller, period.planned->q, period.commands, progress);
  }
  progress.priority = controller.priority();
  if (progress.state == msg::GoalState::GOAL_ACTIVE && starved_ > kBlockedAfter) {
    progress.state = msg::GoalState::GOAL_BLOCKED;
  }
  return progress;
}

}  // namespace hecaton::services
