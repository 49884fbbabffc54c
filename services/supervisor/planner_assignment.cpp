#include "services/supervisor/planner_assignment.hpp"

#include <algorithm>
#include <utility>

#include "services/runtime/log.hpp"

namespace hecaton::services {

PlannerAssignment::PlannerAssignment(std::vector<ArmPlanners> arms, const Limits& limits, bus::Clock::time_point began)
    : failover_(std::move(arms)), limits_(limits), began_(began) {
  for (const ArmPlanners& arm : failover_.arms()) {
    backoff_.emplace(arm.arm, FailoverBackoff(limits.takeover_lease, limits.host_lease));
  }
}

bool PlannerAssignment::update(const Cell& cell) {
  const auto health = [&](const std::string& arm, const std::string& planner) {
    return health_of(observe(cell, arm, planner), {takeover_lease(cell, arm), limits_.host_lease});
  };
  const bool leads = cell.leadership.role() == Leadership::Role::kLeading;
  const bool granted = leads && failover_.decide(health, cell.leadership);
  for (const ArmPlanners& arm : failover_.arms()) {
    const ArmLease lease = failover_.lease(arm.arm);
    const std::string before = cell.detector.in_charge(arm.arm);
    if (lease.planner.empty() || lease.planner == before) continue;
    if (granted && !cell.detector.ended(before)) backoff_.at(arm.arm).replaced(since_epoch(cell.now));
    cell.detector.put_in_charge(arm.arm, lease.planner);
    in_charge_since_[arm.arm] = cell.now;
    log_info("planner in charge", {{"arm", arm.arm}, {"planner", lease.planner}, {"term", lease.term}});
  }
  return granted;
}

Time PlannerAssignment::takeover_lease(const Cell& cell, const std::string& arm) const {
  return backoff_.at(arm).at(since_epoch(cell.now));
}

PlannerObservations PlannerAssignment::observe(const Cell& cell, const std::string& arm,
                                               const std::string& planner) const {
  const auto* beat = find(cell.snapshot.heartbeats, planner);
  PlannerObservations seen;
  seen.ended = cell.detector.ended(planner);
  seen.silence = cell.detector.silence(planner);
  seen.stands_by = beat && beat->value.state() == msg::NodeState::NODE_STANDBY;
  if (planner != cell.detector.in_charge(arm)) return seen;
  const auto since = in_charge_since_.find(arm);
  seen.in_charge = cell.now - (since == in_charge_since_.end() ? began_ : since->second);
  const auto* state = find(cell.snapshot.arms, arm);
  if (!state || state->value.term() == 0 || cell.now - state->at >= takeover_lease(cell, arm)) return seen;
  const std::chrono::duration<double> uncommanded(state->value.command_age() + state->age(cell.now));
  seen.uncommanded = std::chrono::duration_cast<Time>(uncommanded);
  return seen;
}

bus::Clock::time_point PlannerAssignment::takeover_due(const Cell& cell) const {
  auto due = bus::Clock::time_point::max();
  for (const ArmPlanners& arm : failover_.arms()) {
    const PlannerObservations seen = observe(cell, arm.arm, cell.detector.in_charge(arm.arm));
    if (!seen.silence) continue;
    const Time silence = std::min(*seen.silence, seen.uncommanded.value_or(*seen.silence));
    const Time left = takeover_lease(cell, arm.arm) - silence;
    if (left > Time(0)) due = std::min(due, cell.now + left);
  }
  return due;
}

}  // namespace hecaton::services
