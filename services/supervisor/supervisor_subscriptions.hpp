#pragma once
/// Everything that the supervisor receives, brought from the bus to the parts that it concerns.

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
#include "services/supervisor/cell_snapshot.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/failover/leadership.hpp"
#include "services/supervisor/failover/planner_failover.hpp"
#include "services/supervisor/messages.hpp"

namespace hecaton::services {

class SupervisorSubscriptions {
 public:
  struct Listeners {
    CellSnapshot& snapshot;
    FaultDetector& detector;
    Leadership& leadership;
    PlannerFailover& failover;
  };

  struct Self {
    std::string node;
    std::string host;
    bool remembers = false;  ///< what was told of the past
  };

  /// Requests and process events are announced in `urgent`, all the rest in `quiet`.
  SupervisorSubscriptions(bus::Participant& participant, Self self, bus::Mailbox& urgent, bus::Mailbox& quiet);

  /// Brings in what has arrived. `self`: any endpoint of ours.
  void listen(const bus::EndpointId& self, const Listeners& to);
  /// When the newest cell mode or heartbeat of another host arrived. What is heard of our own host counts only when
  /// nothing else has been heard for a while: before, we have rather been cut off ourselves.
  [[nodiscard]] Time newest_arrival() const;
  [[nodiscard]] std::vector<bus::Sample<msg::SupervisorRequest>> requests() { return readers_.requests.take(); }

  /// How our own predecessor ended, once our agent has told that it started us in its place.
  [[nodiscard]] std::optional<ProcessExit> take_predecessor();
  /// The newest cell mode of another supervisor that led since take_other_mode().
  [[nodiscard]] const std::optional<msg::CellMode>& other_mode() const { return leader_.mode; }
  /// When the last one of any arrived.
  [[nodiscard]] Time other_mode_at() const { return leader_.at; }
  /// Grows with everything that others tell of faults.
  [[nodiscard]] std::uint64_t fault_news() const { return faults_.news; }
  /// The newest cell mode of another supervisor that led since the last call.
  [[nodiscard]] std::optional<msg::CellMode> take_other_mode() { return std::exchange(leader_.mode, std::nullopt); }
  [[nodiscard]] msg::ModeNumber newest_mode_of_others() const;
  /// The node that sent the newest of them; empty: none did.
  [[nodiscard]] const std::string& leader() const { return leader_.node; }
  /// Whoever leads answers for what others told while they led, also on another side of a partition: adopts what was
  /// heard since the last call. While we lead, listen() does it.
  void adopt_faults(FaultDetector& watch, const Clocks& clocks);
  /// What others told of faults, by id.
  [[nodiscard]] const std::map<std::string, msg::Fault>& faults_of_others() const { return faults_.told.all(); }

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

  struct Readers {
    Readers(bus::Participant& participant, bus::Mailbox& urgent, bus::Mailbox& quiet);
    bus::Reader<msg::SupervisorRequest> requests;
    bus::Reader<msg::ProcessEvent> processes;
    bus::Reader<msg::Heartbeat> heartbeats;
    bus::Reader<msg::Reachability> rows;
    bus::Reader<msg::ArmState> arms;
    bus::Reader<msg::GoalStatus> goals;
    bus::Reader<msg::ObstacleShapes> shapes;
    bus::Reader<msg::ObstacleStates> states;
    bus::Reader<msg::RefereeReport> contacts;
    bus::Reader<msg::CellMode> modes;
    bus::Reader<msg::Fault> faults;
  };
  /// The newest arrivals from our own host and from others.
  struct Arrivals {
    Time near{0};
    Time far{0};
  };
  /// Another supervisor that led.
  struct Leader {
    std::optional<msg::CellMode> mode{};  // its newest
    Time at{0};                           // when it arrived
    std::string node{};
  };
  struct FaultsOfOthers {
    ToldFaults told{};
    std::uint64_t news = 0;
    std::set<std::string> unadopted{};  // ids of those that we have not made ours yet
  };
  struct Processes {
    std::optional<ProcessExit> own_exit{};
    std::optional<ProcessExit> predecessor{};
    std::map<std::string, Acquaintance, std::less<>> agents{};  // by node
    std::vector<bus::Sample<msg::ProcessEvent>> early{};        // of agents that have not sent a heartbeat yet
  };

  Self self_;
  Readers readers_;
  Arrivals newest_;
  Leader leader_;
  FaultsOfOthers faults_;
  Processes processes_;
};

}  // namespace hecaton::services
