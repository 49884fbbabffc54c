#pragma once
/// The nodes that a supervisor expects, and how soon their silence counts. Pure.

#include <chrono>
#include <cstdint>
#include <set>
#include <string>

#include "services/supervisor/detection/host_monitor.hpp"
#include "services/supervisor/detection/liveness.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

struct ExpectedNode {
  std::string name;
  msg::NodeKind role{};
  std::string arm;   ///< of planners and drivers
  std::string host;  ///< where it runs
};

struct DetectionLimits {
  Time loop_period = std::chrono::milliseconds(5);  ///< of the supervisor's loop
  Time loop_limit = std::chrono::milliseconds(12);  ///< a later turn is a stall of the supervisor
  Time heartbeat_period = std::chrono::milliseconds(10);
  LivenessLimits node;                               ///< of heartbeats
  Time host_lease = std::chrono::milliseconds(100);  ///< silence of a host, and of its agent
  /// Within this all nodes of a host that was away return: longer than any rediscovery (services/bus/reunion.hpp).
  Time rediscovery = std::chrono::seconds(5);
  Time sure_return = std::chrono::seconds(1);         ///< heard for this without a gap, a node has returned for good
  Time arm_stream = std::chrono::milliseconds(20);    ///< silence of ArmState, while the driver's heartbeats arrive
  Time world_stream = std::chrono::milliseconds(50);  ///< silence of ObstacleStates, likewise
  Time arm_period = std::chrono::milliseconds(4);     ///< of ArmState
  Time world_period = std::chrono::milliseconds(10);  ///< of ObstacleStates
  std::set<msg::CauseKind> waits_for_resume{};        ///< what such a fault holds stays held until people resume it

  [[nodiscard]] HostLimits hosts() const;
  /// A fault of a host or of its link waits where CAUSE_HOST_LOST does.
  [[nodiscard]] bool waits(msg::CauseKind kind) const;
};

}  // namespace hecaton::services
