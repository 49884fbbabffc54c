#pragma once
/// What the supervisor receives: the readers of all topics, and the distribution of their samples to the snapshot, the
/// detector, leadership and failover.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/latest_faults.hpp"
#include "services/supervisor/cell_publisher.hpp"
#include "services/supervisor/cell_snapshot.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/failover/leadership.hpp"
#include "services/supervisor/failover/planner_failover.hpp"

namespace hecaton::services {

/// One thread: that of the supervisor's loop.
class SupervisorSubscriptions {
 public:
  struct Consumers {
    CellSnapshot& snapshot;
    FaultDetector& detector;
    Leadership& leadership;
    PlannerFailover& failover;
  };

  struct Self {
    std::string node;
    std::string host;
    bool has_checkpoint = false;  ///< it knows which faults were published in the past
  };

  /// Requests and process events notify `urgent`, other topics `quiet`. `participant` and the mailboxes must outlive
  /// the subscriptions. Throws as bus::Reader does.
  SupervisorSubscriptions(bus::Participant& participant, Self self, bus::Mailbox& urgent, bus::Mailbox& quiet);

  /// Takes all samples that have arrived. `self`: any endpoint of this supervisor.
  void receive(const bus::EndpointId& self, const Consumers& to);
  [[nodiscard]] std::vector<bus::Sample<msg::SupervisorRequest>> requests() { return readers_.requests.take(); }

  /// Arrival of the newest cell mode or heartbeat from another host. Packets of the own host count only after 1 s
  /// without any from others: before that this supervisor is more likely cut off itself.
  [[nodiscard]] Time newest_arrival() const;

  /// How the previous process of this supervisor ended, once the agent has reported that it started this one instead.
  [[nodiscard]] std::optional<ProcessExit> take_own_predecessor_exit();

  /// The newest cell mode of another supervisor since take_leader_mode().
  [[nodiscard]] const std::optional<msg::CellMode>& leader_mode() const { return leader_.mode; }
  [[nodiscard]] std::optional<msg::CellMode> take_leader_mode() { return std::exchange(leader_.mode, std::nullopt); }
  /// Arrival of the last cell mode of another supervisor.
  [[nodiscard]] Time leader_heard_at() const { return leader_.at; }
  /// The node that sent it; empty: none did.
  [[nodiscard]] const std::string& leader() const { return leader_.node; }
  /// Number of leader_mode(), for the heartbeat; zeros: there is none.
  [[nodiscard]] msg::ModeNumber acknowledged_mode() const;

  /// Newest reports of faults by other supervisors, by id.
  [[nodiscard]] const std::map<std::string, msg::Fault>& published_by_others() const { return faults_.latest.all(); }
  /// Grows with every change of published_by_others().
  [[nodiscard]] std::uint64_t fault_revision() const { return faults_.revision; }
  /// Gives the detector what others have published of faults since the last call. A leader is responsible for faults of
  /// all earlier leaders, also on another side of a partition; while this supervisor leads, receive() calls it.
  void adopt_faults(FaultDetector& detector, const Clocks& clocks);

 private:
  void receive_modes(const bus::EndpointId& self, const Consumers& to);
  void receive_faults(const bus::EndpointId& self);
  void receive_heartbeats(const Consumers& to);
  /// Forgets the helper that was heard least lately when there are too many for a new one.
  void make_room_for(const std::string& helper, const Consumers& to);
  void receive_rows(const Consumers& to);
  void receive_arm_states(const Consumers& to);
  void receive_process_events(const Consumers& to);
  void apply_process_event(const bus::Sample<msg::ProcessEvent>& sample, const Consumers& to);
  void receive_world(const Consumers& to);

  /// An agent at its first heartbeat.
  struct KnownAgent {
    bus::EndpointId heartbeats;
    std::uint64_t past_events = 0;  ///< number of its last event before that
    Time at{0};                     ///< arrival of that heartbeat
    std::int64_t stamp_ns = 0;      ///< the same instant on the agent's clock
    Time heard{0};                  ///< its last heartbeat
  };
  void note_agent(const bus::Sample<msg::Heartbeat>& sample);
  /// The participant that speaks for a driver or planner: the first that has sent its heartbeats, until it is silent
  /// for kHeld. A driver is also the one that sends the states of its arm.
  struct Speaker {
    msg::NodeKind role{};
    std::string arm{};
    bus::EndpointId heartbeats{};
    Time heard{0};
  };

  /// The speaker that has sent this heartbeat; null: its node is none of the cell, or another participant speaks for
  /// it.
  [[nodiscard]] Speaker* speaker_of(const bus::Sample<msg::Heartbeat>& sample, const FaultDetector& detector);
  /// Takes the term and the lease of a heartbeat of a driver or planner. An intruder would end the supervision by a
  /// heartbeat of any name and a higher term.
  void observe_term(const Speaker& speaker, const bus::Sample<msg::Heartbeat>& sample, const Consumers& to);
  /// The agent that sent this event; null: it has sent no heartbeat yet.
  [[nodiscard]] const KnownAgent* known_agent(const bus::Sample<msg::ProcessEvent>& sample) const;

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
    bus::Reader<msg::ContactReport> contacts;
    bus::Reader<msg::CellMode> modes;
    bus::Reader<msg::Fault> faults;
  };
  /// Newest arrivals.
  struct Arrivals {
    Time own_host{0};
    Time other_hosts{0};
  };
  /// Another supervisor that led.
  struct Leader {
    std::optional<msg::CellMode> mode{};  // newest
    Time at{0};                           // its arrival
    std::string node{};
  };
  struct FaultsOfOthers {
    LatestFaults latest{};
    std::uint64_t revision = 0;
    std::set<std::string> unadopted{};  // ids
  };
  struct Processes {
    std::optional<ProcessExit> own_exit{};
    std::optional<ProcessExit> predecessor{};
    std::map<std::string, KnownAgent, std::less<>> agents{};  // by node
    std::vector<bus::Sample<msg::ProcessEvent>> waiting{};    // of agents that have sent no heartbeat yet
  };

  Self self_;
  Readers readers_;
  Arrivals newest_;
  Leader leader_;
  FaultsOfOthers faults_;
  Processes processes_;
  std::map<std::string, Speaker, std::less<>> speakers_;  // by node; empty before the first heartbeat
};

}  // namespace hecaton::services
