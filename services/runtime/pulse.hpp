#pragma once
/// A service's heartbeat. The working loop itself beats, so that a loop that hangs falls silent.

#include <chrono>
#include <memory>
#include <string>

#include <idl/health.h>

#include "services/bus/participant.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/loop_statistics.hpp"

namespace hecaton::services {

struct PulseIdentity {
  std::string node;
  msg::NodeKind kind = msg::NodeKind::NODE_OTHER;
  std::string subject;  ///< the arm it serves; empty: none
  std::string host;     ///< empty: the machine's own name
};

struct PulseTiming {
  std::chrono::nanoseconds period = std::chrono::milliseconds(10);
  std::chrono::milliseconds deadline{20};
  std::chrono::milliseconds lease{100};
  int alive_fd = -1;  ///< a socket to the agent that waits for signs of life; −1: nobody waits
};

/// What changes from beat to beat.
struct Vital {
  msg::NodeState state = msg::NodeState::NODE_RUNNING;
  msg::Cause cause;  ///< of the state; CAUSE_NONE: nothing to explain
  std::uint64_t term = 0;
  ArmLease lease;                  ///< a planner's: the newest for its arm that it has heard of
  msg::ModeNumber heard_mode;      ///< a supervisor's: the newest of another that it has heard
  std::uint64_t newest_event = 0;  ///< an agent's: number of the last ProcessEvent that it has told
  double oldest_input_age = 0.0;   ///< [s]
  std::string oldest_input;        ///< topic/key
};

class Pulse {
 public:
  Pulse(bus::Participant& participant, PulseIdentity identity, const PulseTiming& timing);
  ~Pulse();

  /// True when the next beat is due: lets the loop assemble a Vital only then. `slack`: half the loop's period, so that
  /// a loop that is a little early against its last beat does not skip a whole turn.
  [[nodiscard]] bool due(std::chrono::steady_clock::time_point now,
                         std::chrono::nanoseconds slack = std::chrono::nanoseconds(0)) const;
  /// Writes a heartbeat now.
  void beat(std::chrono::steady_clock::time_point now, const Vital& vital, const LoopStatistics& loop);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
