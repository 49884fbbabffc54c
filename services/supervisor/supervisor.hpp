#pragma once
/// The supervisor of a cell. It judges which nodes work, decides which arms may move and which planners command them,
/// publishes the cell mode and faults, and answers requests. Requests and ended processes wake it at once; it judges
/// silence every kTurn.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/shutdown.hpp"
#include "services/supervisor/cell_publisher.hpp"
#include "services/supervisor/cell_snapshot.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/detection/standing_arms.hpp"
#include "services/supervisor/failover/leadership.hpp"
#include "services/supervisor/planner_assignment.hpp"
#include "services/supervisor/replication/replicator.hpp"
#include "services/supervisor/supervisor_subscriptions.hpp"

namespace hecaton::services {

/// The supervisors of a cell, and which of them this process is.
struct SupervisorPlace {
  std::vector<PlacedNode> supervisors;
  std::size_t index;  ///< of this one
  std::string node;
  std::string host;
};

/// Requests that wait: orders until the supervisor leads, and replies until the standby has the order.
class RequestQueue {
 public:
  /// `alone`: the cell has no other supervisor.
  explicit RequestQueue(bool alone) : alone_(alone) {}

  /// Of the requests that have arrived, those to answer now, in their order. While it listens, a supervisor that is
  /// alone answers status requests and keeps orders until it leads; another one ignores requests. A standby ignores
  /// them.
  [[nodiscard]] std::vector<msg::SupervisorRequest> take(std::vector<bus::Sample<msg::SupervisorRequest>> arrived,
                                                         Leadership::Role role);

  /// Replies to executed orders.
  [[nodiscard]] DeferredReplies<msg::SupervisorRequest>& deferred() { return deferred_; }

 private:
  bool alone_;
  std::vector<msg::SupervisorRequest> waiting_;  ///< orders that arrived before this supervisor leads
  DeferredReplies<msg::SupervisorRequest> deferred_;
};

/// Logs once that every node was heard.
class StartupLog {
 public:
  void matched(bus::Clock::time_point at) {
    if (!complete_) newest_match_ = at;
  }
  /// Call it once in each turn.
  void update(const FaultDetector& detector, bus::Clock::time_point now);

 private:
  std::optional<bus::Clock::time_point> first_heard_;  ///< of any node
  bus::Clock::time_point newest_match_{};              ///< of any reader, until complete
  bool complete_ = false;                              ///< every node was heard
};

class Supervisor {
 public:
  static constexpr std::chrono::milliseconds kTurn{5};

  /// options.checkpoint: file of the term, the orders and the faults. `file` and `shutdown` must outlive the
  /// supervisor. Throws std::runtime_error with a sentence.
  Supervisor(const config::CellFile& file, const ServiceOptions& options, ShutdownSignal& shutdown);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// Returns when `shutdown` is requested.
  void run();

 private:
  struct Connection {
    bus::Mailbox urgent;
    bus::Mailbox quiet;
    bus::Participant participant;
    Connection(const config::CellFile& file, const ServiceOptions& options, const std::string& node);
  };
  struct Turns {
    bus::Clock::time_point began;
    bus::Clock::time_point last;                           ///< outside of an absence
    std::optional<bus::Clock::time_point> absent_since{};  ///< the participant recovers from a stall of this process
    bus::Clock::time_point failover_due = bus::Clock::time_point::max();
  };
  struct Heartbeats {
    HeartbeatPublisher publisher;
    LoopStatistics loop;
  };

  /// One turn: receive, decide leadership, assign planners, judge, publish, answer.
  void turn(bus::Clock::time_point now);
  /// False while the participant recovers. After that it reports the own absence as a fault.
  [[nodiscard]] bool is_present(bus::Clock::time_point now);
  void receive(bus::Clock::time_point now);
  /// True while the handshake with another supervisor of the cell is under way.
  [[nodiscard]] bool another_joins() const;
  /// Becomes leader, or steps down. `led`: before this turn's messages.
  void decide_leadership(bool led, bus::Clock::time_point last_turn);
  void assign_planners();
  void judge();
  void publish_mode(bus::Clock::time_point now);
  void publish_faults();
  void answer();
  void publish_heartbeat(bus::Clock::time_point now);

  void report_own_stall(const std::string& what, bus::Clock::time_point since);
  void step_down();
  void answer(const msg::SupervisorRequest& request);
  /// Returns why the request was refused, or CAUSE_NONE.
  [[nodiscard]] msg::Cause execute(const msg::SupervisorRequest& request);
  void reply(const msg::SupervisorRequest& request, const msg::Cause& refusal);
  /// Sequence number of this leader's newest cell mode that the standby has; empty: there is no standby.
  [[nodiscard]] std::optional<std::uint64_t> acknowledged_by_standby() const;
  [[nodiscard]] bool is(Leadership::Role role) const { return leadership_.role() == role; }
  [[nodiscard]] Replicator::Cell replicated();
  [[nodiscard]] PlannerAssignment::Cell assigned();

  const config::CellFile& file_;
  std::vector<bool> stop_without_driver_;  ///< each arm
  SupervisorPlace place_;
  ShutdownSignal& shutdown_;
  Turns turns_;
  FaultDetector detector_;
  CellSnapshot snapshot_;
  Replicator replicator_;
  PlannerAssignment planners_;
  RequestQueue requests_;
  StartupLog startup_;
  StandingArms standing_;
  Connection connection_;
  SupervisorSubscriptions subscriptions_;
  Leadership leadership_;  ///< after the subscriptions: it begins to listen when they exist
  CellPublisher publisher_;
  Heartbeats heartbeats_;
};

}  // namespace hecaton::services
