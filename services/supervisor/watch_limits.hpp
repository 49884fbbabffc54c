#pragma once
/// Whom a supervisor watches, and how soon silence counts. Standard library only.

#include <chrono>
#include <cstdint>
#include <set>
#include <string>

#include "services/supervisor/fault_list.hpp"
#include "services/supervisor/liveness.hpp"

namespace hecaton::services {

struct ExpectedNode {
  std::string name;
  msg::NodeKind role = msg::NodeKind::NODE_OTHER;
  std::string arm;   ///< of planners and drivers
  std::string host;  ///< where it runs
};

struct WatchLimits {
  Time loop_period = std::chrono::milliseconds(5);  ///< of our own loop
  Time loop_limit = std::chrono::milliseconds(12);  ///< a turn later than this is a stall of ours
  Time heartbeat_period = std::chrono::milliseconds(10);
  LivenessLimits node;                               ///< of heartbeats
  Time host_lease = std::chrono::milliseconds(100);  ///< silence of an agent
  /// Within which the nodes of a lost host return after its agent: longer than any reunion of participants
  /// (services/bus/reunion.hpp).
  Time host_return = std::chrono::seconds(5);
  /// For so long nobody of another host may say that it has heard us: shorter than anybody takes to leave us alone.
  Time unheard = std::chrono::milliseconds(500);
  /// Who was heard so long without a gap since then has returned: it is not lost again by the same reunion.
  Time sure_return = std::chrono::seconds(1);
  Time arm_stream = std::chrono::milliseconds(20);    ///< silence of ArmState, while the driver's loop is heard
  Time world_stream = std::chrono::milliseconds(50);  ///< silence of ObstacleStates, likewise
  Time arm_period = std::chrono::milliseconds(4);     ///< of ArmState
  Time world_period = std::chrono::milliseconds(10);  ///< of ObstacleStates
  std::set<msg::CauseKind> waits_for_resume{};        ///< what such a fault holds stays held until people resume it
};

}  // namespace hecaton::services
