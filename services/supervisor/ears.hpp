#pragma once
/// Everything that the supervisor hears, brought from the bus into its picture and its watch.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/told_faults.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/leadership.hpp"
#include "services/supervisor/messages.hpp"
#include "services/supervisor/picture.hpp"
#include "services/supervisor/succession.hpp"

namespace hecaton::services {

class Ears {
 public:
  struct Listeners {
    Picture& picture;
    FaultDetector& watch;
    Leadership& leadership;
    Succession& succession;
  };

  struct Self {
    std::string node;
    std::string host;
    bool remembers = false;  ///< what was told of the past
  };

  /// Requests and process events are announced in `urgent`, all the rest in `quiet`.
  Ears(bus::Participant& participant, Self self, bus::Mailbox& urgent, bus::Mailbox& quiet);

  /// Brings in what has arrived. `self`: any endpoint of ours.
  void listen(const bus::EndpointId& self, const Listeners& to);
  /// When the newest cell mode or heartbeat of another host arrived. What is heard of our own host counts only when
  /// nothing else has been heard for a while: before, we have rather been cut off ourselves.
  [[nodiscard]] Time newest_arrival() const;
  [[nodiscard]] std::vector<bus::Sample<msg::SupervisorRequest>> requests() { return requests_.take(); }

  /// How our own predecessor ended, once our agent has told that it started us in its place.
  [[nodiscard]] std::optional<ProcessExit> take_predecessor();
  /// The newest cell mode of another supervisor that led since take_other_mode().
  [[nodiscard]] const std::optional<msg::CellMode>& other_mode() const { return other_mode_; }
  /// When the last one of any arrived.
  [[nodiscard]] Time other_mode_at() const { return other_mode_at_; }
  /// Grows with everything that others tell of faults.
  [[nodiscard]] std::uint64_t fault_news() const { return fault_news_; }
  /// The newest cell mode of another supervisor that led since the last call.
  [[nodiscard]] std::optional<msg::CellMode> take_other_mode() { return std::exchange(other_mode_, std::nullopt); }
  [[nodiscard]] msg::ModeNumber newest_mode_of_others() const;
  /// Whoever leads answers for what others told while they led, also on another side of a partition: adopts what was
  /// heard since the last call. While we lead, listen() does it.
  void adopt_faults(FaultDetector& watch, const Clocks& clocks);
  /// What others told of faults, by id.
  [[nodiscard]] const std::map<std::string, msg::Fault>& faults_of_others() const { return other_faults_.all(); }

 private:
  void hear_leaders(const bus::EndpointId& self, const Listeners& to);
  void hear_faults(const bus::EndpointId& self);
  void hear_nodes(const Listeners& to);
  void hear_rows(const Listeners& to);
  void hear_drivers(const Listeners& to);
  void hear_processes(const Listeners& to);
  void hear_process(const bus::Sample<msg::ProcessEvent>& sample, const Listeners& to);
  void hear_world(const Listeners& to);

  /// An agent, as we first heard it.
  struct Acquaintance {
    bus::EndpointId heartbeats;
    std::uint64_t past_events = 0;  ///< it had told so many by then
    Time at{0};                     ///< when that was
    std::int64_t stamp_ns = 0;      ///< the same on its own clock
  };
  void meet_agent(const bus::Sample<msg::Heartbeat>& sample);
  /// Of the agent that told of this event; null: it has not beaten yet.
  [[nodiscard]] const Acquaintance* acquaintance(const bus::Sample<msg::ProcessEvent>& sample) const;

  Self self_;
  bus::Reader<msg::SupervisorRequest> requests_;
  bus::Reader<msg::ProcessEvent> processes_;
  bus::Reader<msg::Heartbeat> heartbeats_;
  bus::Reader<msg::Reachability> rows_;
  bus::Reader<msg::ArmState> arms_;
  bus::Reader<msg::GoalStatus> goals_;
  bus::Reader<msg::ObstacleShapes> shapes_;
  bus::Reader<msg::ObstacleStates> states_;
  bus::Reader<msg::RefereeReport> referee_;
  bus::Reader<msg::CellMode> modes_;
  bus::Reader<msg::Fault> faults_;
  std::optional<ProcessExit> own_exit_, predecessor_;
  std::optional<msg::CellMode> other_mode_;
  Time other_mode_at_{0};
  std::string leader_;                   // who told it
  Time newest_near_{0}, newest_far_{0};  // arrivals from our own host and from others
  ToldFaults other_faults_;
  std::uint64_t fault_news_ = 0;
  std::set<std::string> unadopted_;  // ids of faults that others told and we have not made ours yet
  std::map<std::string, Acquaintance, std::less<>> agents_;   // by node
  std::vector<bus::Sample<msg::ProcessEvent>> early_events_;  // of agents that have not beaten yet
};

}  // namespace hecaton::services
