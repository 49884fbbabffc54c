#pragma once
/// Everything that the supervisor hears, brought from the bus into its picture and its watch.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/supervisor/cell_watch.hpp"
#include "services/supervisor/leadership.hpp"
#include "services/supervisor/picture.hpp"

namespace hecaton::services {

class Ears {
 public:
  /// Requests and process events are announced in `urgent`, all the rest in `quiet`.
  Ears(bus::Participant& participant, bus::Mailbox& urgent, bus::Mailbox& quiet);

  /// Brings in what has arrived. `self`: any endpoint of ours.
  void listen(const bus::EndpointId& self, Picture& picture, CellWatch& watch, Leadership& leadership);
  [[nodiscard]] std::vector<bus::Sample<msg::SupervisorRequest>> requests() { return requests_.take(); }

  /// How our own predecessor ended, once our agent has told that it started us in its place.
  [[nodiscard]] std::optional<ProcessExit> take_predecessor();
  /// The last cell mode of another supervisor that led since the last call.
  [[nodiscard]] std::optional<msg::CellMode> take_other_mode() { return std::exchange(other_mode_, std::nullopt); }

 private:
  void hear_nodes(Picture& picture, CellWatch& watch, Leadership& leadership);
  void hear_processes(Picture& picture, CellWatch& watch);
  void hear_world(Picture& picture, CellWatch& watch);

  bus::Reader<msg::SupervisorRequest> requests_;
  bus::Reader<msg::ProcessEvent> processes_;
  bus::Reader<msg::Heartbeat> heartbeats_;
  bus::Reader<msg::ArmState> arms_;
  bus::Reader<msg::GoalStatus> goals_;
  bus::Reader<msg::ObstacleShapes> shapes_;
  bus::Reader<msg::ObstacleStates> states_;
  bus::Reader<msg::RefereeReport> referee_;
  bus::Reader<msg::CellMode> modes_;
  std::optional<ProcessExit> own_exit_, predecessor_;
  std::optional<msg::CellMode> other_mode_;
};

}  // namespace hecaton::services
