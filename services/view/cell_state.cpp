#include "services/view/cell_state.hpp"

#include <chrono>
#include <tuple>
#include <utility>

#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/standstill.hpp"

namespace hecaton::services {
namespace {

/// A node of a cell that just came up, or that this process has just found, is not silent yet.
constexpr std::chrono::seconds kDiscovery{3};

/// `a` is a later status of the same arm than `b`: stamps of one term have one clock.
bool is_later(const msg::GoalStatus& a, const msg::GoalStatus& b) {
  return std::tuple(a.term(), a.stamp_ns(), a.sequence_number()) >
         std::tuple(b.term(), b.stamp_ns(), b.sequence_number());
}

}  // namespace

void CellState::apply(const bus::Sample<msg::GoalStatus>& sample) {
  // The statuses of a replaced goal and of the new one may arrive in either order.
  if (sample.disposed || sample.value.state() == msg::GoalState::GOAL_REPLACED) return;
  const auto [newest, first] = goals_.try_emplace(sample.value.arm(), sample);
  if (!first && is_later(sample.value, newest->second.value)) newest->second = sample;
}

void CellState::apply(const bus::Sample<msg::ObstacleShapes>& sample) {
  auto changed = std::make_shared<Obstacles>(*obstacles_);
  if (sample.disposed) {
    changed->erase(sample.key);
  } else {
    (*changed)[sample.value.name()] = sample.value.obstacle();
  }
  obstacles_ = std::move(changed);
  ++obstacle_edition_;
}

void CellState::apply(const bus::Sample<msg::Fault>& sample) {
  if (sample.disposed) {
    faults_.erase(sample.key);
  } else {
    faults_.update(sample.value);
  }
}

void CellState::apply(const bus::Sample<msg::CellMode>& sample) {
  if (!sample.disposed) modes_.apply(sample.value, sample.received, sample.writer);
}

void CellState::begin_anew(bus::Clock::time_point began) {
  const std::uint64_t edition = obstacle_edition_ + 1;
  *this = CellState(*file_, began);
  obstacle_edition_ = edition;
}

bool CellState::alive(const bus::Sample<msg::Heartbeat>& heartbeat, bus::Clock::time_point now) const {
  return heartbeat.age(now) <= file_->supervision.host_lease;
}

std::string CellState::planner_of(std::string_view arm) const {
  const std::string leased = mode().lease(arm).planner;
  return leased.empty() ? planner_node(arm) : leased;
}

msg::Cause CellState::first_awaited(const std::string& arm, bus::Clock::time_point now) const {
  for (const std::string& node : {driver_node(arm), planner_of(arm), world_node()}) {
    for (const auto& [id, fault] : faults_.all()) {
      if (!fault.cleared() && fault.cause().subject() == node) return fault.cause();
    }
    const auto* heartbeat = this->heartbeat(node);
    if (heartbeat == nullptr && now - began_ > kDiscovery) {
      return make_cause(msg::CauseKind::CAUSE_NODE_MISSING, node, node + " has not appeared yet");
    }
    if (heartbeat != nullptr && !alive(*heartbeat, now)) {
      return make_cause(msg::CauseKind::CAUSE_NODE_SILENT, node, node + " is silent");
    }
  }
  return {};
}

msg::Cause CellState::waiting_for(const std::string& arm, bus::Clock::time_point now) const {
  if (msg::Cause held = mode().why(arm); !is_none(held)) return held;
  if (msg::Cause awaited = first_awaited(arm, now); !is_none(awaited)) return awaited;
  const auto* measured = state(arm);
  const auto* newest = goal(arm);
  // An arm that still brakes after its goal has ended waits for the next goal already.
  if (measured != nullptr && moves(measured->value, mode().speed(arm)) &&
      !(newest != nullptr && is_final(newest->value.state()))) {
    return {};
  }
  const auto* planner = heartbeat(planner_of(arm));
  if (planner != nullptr && planner->value.state() == msg::NodeState::NODE_DEGRADED &&
      !is_none(planner->value.cause())) {
    msg::Cause cause = planner->value.cause();
    cause.text(planner->value.node() + ": " + cause.text());
    return cause;
  }
  if (measured != nullptr && measured->value.mode() != msg::ArmMode::ARM_RUNNING &&
      !(newest != nullptr && awaits_goal(measured->value, newest->value))) {
    return drive_cause(measured->value);
  }
  if (newest != nullptr) return goal_cause(newest->value);
  return make_cause(msg::CauseKind::CAUSE_NO_GOAL, {}, "a goal");
}

}  // namespace hecaton::services
