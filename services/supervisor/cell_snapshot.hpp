#pragma once
/// The newest sample of everything that the supervisor receives, with its arrival. Values only: FaultDetector judges.

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

/// Time as the detector counts it.
[[nodiscard]] inline Time since_epoch(bus::Clock::time_point at) {
  return at.time_since_epoch();
}

template <class T>
struct Received {
  T value;
  bus::Clock::time_point at;
  bus::EndpointId writer;

  /// [s]
  [[nodiscard]] double age(bus::Clock::time_point now) const { return std::chrono::duration<double>(now - at).count(); }
};

template <class T>
[[nodiscard]] Received<T> received(const bus::Sample<T>& sample) {
  return {sample.value, sample.received, sample.writer};
}

template <class T>
using ReceivedByName = std::map<std::string, Received<T>, std::less<>>;

/// The entry of `name`, or null.
template <class T>
[[nodiscard]] const Received<T>* find(const ReceivedByName<T>& all, std::string_view name) {
  const auto found = all.find(name);
  return found == all.end() ? nullptr : &found->second;
}

struct CellSnapshot {
  ReceivedByName<msg::Heartbeat> heartbeats;      ///< by node
  ReceivedByName<msg::ProcessEvent> processes;    ///< by process, newest
  ReceivedByName<msg::ArmState> arms;             ///< by arm
  std::set<std::string, std::less<>> observed;    ///< arms that others move, as their drivers said last
  ReceivedByName<msg::GoalStatus> goals;          ///< by arm, newest
  ReceivedByName<msg::GoalStatus> lost_goals;     ///< by arm: had not ended when its planner's process was replaced
  ReceivedByName<msg::ObstacleShapes> obstacles;  ///< by obstacle
  std::optional<Received<msg::ObstacleStates>> states;
  std::optional<Received<msg::ContactReport>> contact_report;

  /// Takes each state of an arm in turn. A driver whose device has failed, or has measured nothing yet, does not say
  /// whether others move the arm.
  void update_observed(const msg::ArmState& state);
  /// Keeps the newest goal of the arm: a late joiner receives several in any order.
  void update_goal(const bus::Sample<msg::GoalStatus>& sample);
  /// A planner whose process was replaced has lost its goal, unless it publishes the goal again.
  void update_heartbeat(const bus::Sample<msg::Heartbeat>& sample);
  /// States of a new world process remove obstacles that only its predecessor had: a process that dies disposes none.
  void update_obstacle_states(const bus::Sample<msg::ObstacleStates>& sample);
};

}  // namespace hecaton::services
