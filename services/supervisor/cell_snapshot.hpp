#pragma once
/// The last that was heard of everything, with the time of arrival. Values only: who judges them is FaultDetector.

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

/// As the watch counts it.
[[nodiscard]] inline Time since_epoch(bus::Clock::time_point at) {
  return at.time_since_epoch();
}

template <class T>
struct Heard {
  T value;
  bus::Clock::time_point at;
  bus::EndpointId writer;

  /// [s]
  [[nodiscard]] double age(bus::Clock::time_point now) const { return std::chrono::duration<double>(now - at).count(); }
};

template <class T>
[[nodiscard]] Heard<T> heard(const bus::Sample<T>& sample) {
  return {sample.value, sample.received, sample.writer};
}

template <class T>
using HeardByName = std::map<std::string, Heard<T>, std::less<>>;

/// The entry of `name`, or null.
template <class T>
[[nodiscard]] const Heard<T>* find(const HeardByName<T>& all, std::string_view name) {
  const auto found = all.find(name);
  return found == all.end() ? nullptr : &found->second;
}

struct CellSnapshot {
  HeardByName<msg::Heartbeat> heartbeats;      ///< by node
  HeardByName<msg::ProcessEvent> processes;    ///< by process, newest
  HeardByName<msg::ArmState> arms;             ///< by arm
  HeardByName<msg::GoalStatus> goals;          ///< by arm, newest
  HeardByName<msg::GoalStatus> lost_goals;     ///< by arm: was not over when the planner that had it was replaced
  HeardByName<msg::ObstacleShapes> obstacles;  ///< by obstacle
  std::optional<Heard<msg::ObstacleStates>> states;
  std::optional<Heard<msg::RefereeReport>> referee;

  /// Keeps the newest goal of the arm: late joiners get several in any order.
  void take_goal(const bus::Sample<msg::GoalStatus>& sample);
  /// A planner of another process than before has lost what was under way, unless it tells otherwise.
  void take_heartbeat(const bus::Sample<msg::Heartbeat>& sample);
  /// The first of another world end what only its predecessor knew: who dies withdraws nothing.
  void take_states(const bus::Sample<msg::ObstacleStates>& sample);
};

}  // namespace hecaton::services
