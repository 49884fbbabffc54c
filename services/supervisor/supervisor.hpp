#pragma once
/// The supervisor of a cell: receives everything, judges which nodes work, decides which arms may move and which
/// planners command them, publishes the cell's mode and its faults, and answers people. Requests and deaths wake it at
/// once; silence is judged every kTurn.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/pulse.hpp"
#include "services/runtime/shutdown.hpp"
#include "services/supervisor/cell_publisher.hpp"
#include "services/supervisor/cell_snapshot.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/failover/leadership.hpp"
#include "services/supervisor/planner_assignment.hpp"
#include "services/supervisor/replication/replicator.hpp"
#include "services/supervisor/request_queue.hpp"
#include "services/supervisor/supervisor_subscriptions.hpp"

namespace hecaton::services {

/// Which of a cell's supervisors a process is.
struct SupervisorPlace {
  std::vector<PlacedNode> supervisors;
  std::size_t index;  ///< ours among them
  std::string node;
  std::string host;
};

/// Logs what no message tells: that every node was heard once.
class TransitionLog {
 public:
  void matched(bus::Clock::time_point at) {
    if (!complete_) newest_match_ = at;
  }
  /// Once in each turn.
  void look(const FaultDetector& detector, bus::Clock::time_point now);

 private:
  std::optional<bus::Clock::time_point> first_heard_;  ///< of any node
  bus::Clock::time_point newest_match_{};              ///< of any reader, until complete
  bool complete_ = false;                              ///< every node was heard once
};

class Supervisor {
 public:
  static constexpr std::chrono::milliseconds kTurn{5};

  /// Term, orders and faults survive in the file of options.memory. Throws std::runtime_error with a sentence.
  Supervisor(const config::CellFile& file, const ServiceOptions& options, ShutdownSignal& shutdown);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// Until the process is to end.
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
    bus::Clock::time_point last;                           ///< that was not in an absence
    std::optional<bus::Clock::time_point> absent_since{};  ///< the participant hears nobody and is not heard
    bus::Clock::time_point takeover_due = bus::Clock::time_point::max();
  };
  struct Heart {
    Pulse pulse;
    LoopStatistics loop;
  };

  /// One turn: receive, decide who leads, assign planners, judge, publish, answer.
  void turn(bus::Clock::time_point now);
  /// False while the participant is away; lists ourselves as silent when it is back.
  [[nodiscard]] bool is_present(bus::Clock::time_point now);
  void receive(bus::Clock::time_point now);
  /// Takes over the leader's duties, or gives them up. `led`: before this turn's messages.
  void decide_leadership(bool led, bus::Clock::time_point last_turn);
  void assign_planners();
  void judge();
  void publish_mode(bus::Clock::time_point now);
  void publish_faults();
  void answer();
  void beat(bus::Clock::time_point now);

  void report_own_silence(const std::string& what, bus::Clock::time_point since);
  void stand_back();
  void answer(const msg::SupervisorRequest& request);
  [[nodiscard]] msg::Cause obey(const msg::SupervisorRequest& request);
  void reply(const msg::SupervisorRequest& request, const msg::Cause& refusal);
  /// The newest of our cell modes that the standby has; empty: no supervisor stands by.
  [[nodiscard]] std::optional<std::uint64_t> received_by_standby() const;
  [[nodiscard]] bool is(Leadership::Role role) const { return leadership_.role() == role; }
  [[nodiscard]] Replicator::Cell replicated();
  [[nodiscard]] PlannerAssignment::Cell assigned();

  const config::CellFile& file_;
  SupervisorPlace place_;
  ShutdownSignal& shutdown_;
  Turns turns_;
  FaultDetector detector_;
  CellSnapshot snapshot_;
  Replicator replicator_;
  PlannerAssignment planners_;
  RequestQueue requests_;
  TransitionLog transitions_;
  Connection connection_;
  SupervisorSubscriptions subscriptions_;
  Leadership leadership_;  ///< behind the subscriptions: it listens from when there are any
  CellPublisher publisher_;
  Heart heart_;
};

}  // namespace hecaton::services
