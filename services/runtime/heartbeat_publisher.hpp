#pragma once
/// Publishes a node's heartbeat on the topic Heartbeat.

#include <chrono>
#include <memory>
#include <string>

#include <idl/health.h>

#include "services/bus/participant.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/periodic_loop.hpp"

namespace hecaton::services {

struct NodeIdentity {
  std::string node;
  msg::NodeKind kind = msg::NodeKind::NODE_OTHER;
  std::string subject;  ///< the arm that the node serves; empty: none
  std::string host;     ///< of the cell; empty: the machine's own name
};

struct HeartbeatTiming {
  std::chrono::nanoseconds period = std::chrono::milliseconds(10);
  int heartbeat_fd = -1;  ///< a socket to the agent, see ServiceOptions; −1: none
};

/// The part of a heartbeat that the service fills in each time.
struct HealthReport {
  msg::NodeState state = msg::NodeState::NODE_RUNNING;
  msg::Cause cause;                   ///< of the state; CAUSE_NONE: nothing to explain
  std::uint64_t term = 0;             ///< of the newest cell mode that the node has received; 0: none
  ArmLease lease;                     ///< of a planner: the newest lease that it knows for its arm
  msg::ModeNumber acknowledged_mode;  ///< of a supervisor: the newest cell mode of another supervisor
  std::uint64_t newest_event = 0;     ///< of an agent: number of the last ProcessEvent that it has published
  double oldest_input_age = 0.0;      ///< [s]; negative: never received
  std::string oldest_input;           ///< its topic/key
};

/// Publishes heartbeats from the working loop itself, so that a hanging loop falls silent. For one thread.
class HeartbeatPublisher {
 public:
  /// The participant must outlive it. Throws std::runtime_error with a sentence when the writer cannot be made.
  HeartbeatPublisher(bus::Participant& participant, NodeIdentity identity, const HeartbeatTiming& timing);
  ~HeartbeatPublisher();

  /// True when the next heartbeat is due within `slack`. Pass half the loop's period: a loop that is slightly early
  /// must not delay the heartbeat by a whole period.
  [[nodiscard]] bool due(std::chrono::steady_clock::time_point now,
                         std::chrono::nanoseconds slack = std::chrono::nanoseconds(0)) const;
  /// Writes a heartbeat. Every 250 ms it also refreshes the loop's statistics and sends a byte to heartbeat_fd. Logs
  /// the first refusal of the writer.
  void publish(std::chrono::steady_clock::time_point now, const HealthReport& report, const LoopStatistics& loop);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
