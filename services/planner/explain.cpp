#include "services/planner/explain.hpp"

#include <algorithm>
#include <cstdio>

namespace hecaton::services {
namespace {

std::string milliseconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f ms", seconds * 1e3);
  return text;
}

std::string stale(const planner::TickResult& result, const planner::CellGeometry& geometry,
                  std::span<const planner::ArmObservation> arms, std::span<const world::ObstacleState> obstacles) {
  if (result.stale_arm < 0) {
    double age = 0.0;
    for (const auto& obstacle : obstacles) age = std::max(age, obstacle.age);
    return "the last news of the obstacles are " + milliseconds(age) + " old";
  }
  const std::string& name = geometry.arms()[result.stale_arm].name;
  const planner::ArmObservation& arm = arms[result.stale_arm];
  if (!arm.known) return "the state of arm " + name + " was never heard";
  return "the last state of arm " + name + " is " + milliseconds(arm.age) + " old";
}

/// What is in the way, or may be: the lost arm that binds, or when no pair does, any that was lost; empty: none.
std::string lost_arm(const planner::TickResult& result, const planner::CellGeometry& geometry,
                     std::span<const planner::ArmObservation> arms) {
  const bool of_an_arm = result.has_binding && result.binding.counterpart == planner::Counterpart::kArm;
  if (of_an_arm && arms[result.binding.other].lost()) return geometry.arms()[result.binding.other].name;
  if (result.has_binding || result.status != planner::TickStatus::kBlocked) return {};
  const auto found = std::find_if(arms.begin(), arms.end(), [](const auto& arm) { return arm.lost(); });
  return found == arms.end() ? std::string() : geometry.arms()[found - arms.begin()].name;
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
                 std::span<const world::ObstacleState> obstacles, const std::string& hold_reason) {
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
      progress.reason = "no progress" + what_binds(progress);
      progress.trying = "looks for a way along the boundary" + subspaces(result.redraws);
      break;
    }
    case planner::TickStatus::kFollowing:
      if (!result.has_binding) progress.reason = "at its joint limits";
      progress.trying = "follows the boundary" + subspaces(result.redraws);
      break;
    case planner::TickStatus::kDetouring:
      progress.trying = "makes a detour";
      break;
    case planner::TickStatus::kTogether:
      progress.trying = "goes by a plan for all arms that stand in each other's way";
      break;
    case planner::TickStatus::kRouted:
      progress.held_back = result.has_binding || approach.hopeless();
      progress.trying = "goes by a route around what stands in its way";
      break;
    case planner::TickStatus::kYielding:
      progress.trying = "makes room for arm " + geometry.arms()[result.yields_to].name;
      break;
    case planner::TickStatus::kHolding:
      progress.held_back = false;  // by people or a fault, not by what is in its way
      progress.reason = hold_reason;
      progress.trying = "waits";
      break;
    case planner::TickStatus::kStaleInput:
      progress.reason = stale(result, geometry, arms, obstacles);
      progress.trying = "waits for fresh states";
      break;
    case planner::TickStatus::kIdle:
    case planner::TickStatus::kReached:
      progress.held_back = false;
      break;
    case planner::TickStatus::kMoving:
      // A free stretch in the midst of a search ends nothing yet.
      progress.held_back = result.has_binding || approach.hopeless();
      progress.trying =
          result.has_binding ? "goes straight to the goal as far as it is let" : "goes straight to the goal";
      break;
  }
  if (progress.held_back && progress.state == msg::GoalState::GOAL_ACTIVE && approach.hopeless()) {
    progress.state = msg::GoalState::GOAL_BLOCKED;
    char text[64];
    std::snprintf(text, sizeof text, "no way found for %.0f s", approach.lost());
    progress.reason = text + what_binds(progress);
  }
  if (const std::string lost = lost_arm(result, geometry, arms); !lost.empty()) {
    progress.reason += (progress.reason.empty() ? "" : "; ") + ("arm " + lost + " was lost and may be nearer");
  } else if (result.status == planner::TickStatus::kBlocked && !result.has_binding) {
    progress.reason += " within the joint limits";
  }
  return progress;
}

}  // namespace hecaton::services
