#include "services/supervisor/planner_assignment.hpp"

#include <algorithm>
#include <utility>

#include "services/runtime/log.hpp"

namespace hecaton::services {

PlannerAssignment::PlannerAssignment(std::vector<ArmPlanners> arms, const Limits& limits, bus::Clock::time_point began)
    : failover_(std::move(arms)), limits_(limits), began_(began) {
  for (const ArmPlanners& arm : failover_.arms()) {
    backoff_.emplace(arm.arm, FailoverBackoff(limits.failover_timeout, limits.host_lease));
  }
}

bool PlannerAssignment::update(const Cell& cell) {
  const auto health = [&](const std::string& arm, const std::string& planner) {
    return health_of(observe(cell, arm, planner), {failover_timeout(cell, arm), limits_.host_lease});
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

Time PlannerAssignment::failover_timeout(const Cell& cell, const std::string& arm) const {
  return backoff_.at(arm).at(since_epoch(cell.now));
}

PlannerObservations PlannerAssignment::observe(const Cell& cell, const std::string& arm,
                                               const std::string& planner) const {
  const auto* heartbeat = find(cell.snapshot.heartbeats, planner);
  PlannerObservations observed;
  observed.ended = cell.detector.ended(planner);
  observed.silence = cell.detector.silence(planner);
  observed.stands_by = heartbeat && heartbeat->value.state() == msg::NodeState::NODE_STANDBY;
  if (planner != cell.detector.in_charge(arm)) return observed;
  const auto since = in_charge_since_.find(arm);
  observed.time_in_charge = cell.now - (since == in_charge_since_.end() ? began_ : since->second);
  const auto* state = find(cell.snapshot.arms, arm);
  if (!state || state->value.term() == 0 || cell.now - state->at >= failover_timeout(cell, arm)) return observed;
  const std::chrono::duration<double> command_silence(state->value.command_age() + state->age(cell.now));
  observed.command_silence = std::chrono::duration_cast<Time>(command_silence);
  return observed;
}

bus::Clock::time_point PlannerAssignment::failover_due(const Cell& cell) const {
  auto due = bus::Clock::time_point::max();
  for (const ArmPlanners& arm : failover_.arms()) {
    const PlannerObservations observed = observe(cell, arm.arm, cell.detector.in_charge(arm.arm));
    if (!observed.silence) continue;
    const Time silence = std::min(*observed.silence, observed.command_silence.value_or(*observed.silence));
    const Time left = failover_timeout(cell, arm.arm) - silence;
    if (left > Time(0)) due = std::min(due, cell.now + left);
  }
  return due;
}

}  // namespace hecaton::services
