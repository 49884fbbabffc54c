#pragma once
/// What the planner of an arm tells other planners of coupled plans. Pure.

#include <string>
#include <vector>

#include <idl/goal.h>

#include "planner/local/observation.hpp"

namespace hecaton::services {

/// `arms`: names of the cell's arms. `proposal` null: withdraws the proposal. The caller sets arm, node and stamp.
[[nodiscard]] inline msg::CoupledPlan coupled_plan_message(const planner::CoupledPlan* proposal,
                                                           const std::vector<std::string>& arms) {
  msg::CoupledPlan message;
  if (proposal == nullptr) return message;
  message.number(proposal->number);
  for (const int arm : proposal->arms) message.arms().push_back(arms[static_cast<std::size_t>(arm)]);
  message.points(static_cast<std::uint32_t>(proposal->points.size()));
  for (const auto& point : proposal->points) {
    for (const planner::JointVector& q : point) message.q().insert(message.q().end(), q.begin(), q.end());
  }
  return message;
}

/// The same for the progress on a plan.
[[nodiscard]] inline msg::CoupledPlanProgress progress_message(const planner::CoupledPlanProgress& progress,
                                                               const std::vector<std::string>& arms) {
  msg::CoupledPlanProgress message;
  if (progress.proposer >= 0) message.proposer(arms[static_cast<std::size_t>(progress.proposer)]);
  message.number(progress.number);
  message.reached(progress.reached);
  return message;
}

}  // namespace hecaton::services
