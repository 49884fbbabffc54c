#pragma once
/// The agent of a host. It starts the services that the cell file places there, publishes each start and exit within a
/// millisecond, and restarts services that exit or hang. Its services end with it. Their checkpoints stay for the next
/// agent, unless this one was asked to end.

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include <idl/health.h>

#include "services/agent/process_manager.hpp"
#include "services/agent/reachability_reporter.hpp"
#include "services/agent/systemd_notifier.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/run_folder.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services {

struct AgentOptions {
  std::filesystem::path programs;  ///< folder of the services' executables
  std::filesystem::path logs;      ///< folder of their logs; empty: they write to the agent's streams
  bool restart = true;
  bool clean = false;  ///< removes the checkpoints that a killed agent has left
};

class Agent {
 public:
  static constexpr std::chrono::seconds kEndTimeout{2};  ///< for services that were asked to end; then they are killed

  /// `shutdown` must outlive the agent. Throws std::runtime_error with a sentence.
  Agent(const config::CellFile& file, const ServiceOptions& options, const AgentOptions& agent,
        ShutdownSignal& shutdown);
  ~Agent();
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  /// Returns when `shutdown` was requested and all services have ended.
  void run();

 private:
  void wait(bus::Clock::time_point until);
  void turn();
  void publish(const ProcessEvent& event);
  void publish_heartbeat(bus::Clock::time_point now);
  void touch_folders(bus::Clock::time_point now);

  std::chrono::nanoseconds period_;
  ShutdownSignal& shutdown_;
  SystemdNotifier systemd_;
  std::vector<RunFolder> folders_;  // one for each host of this agent
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  bus::Writer<msg::ProcessEvent> events_;
  std::deque<HeartbeatPublisher> heartbeats_;  // one for each host
  ReachabilityReporter reachability_;
  ProcessManager processes_;
  LoopStatistics loop_;
  std::vector<pollfd> descriptors_;
  std::uint64_t sequence_ = 0;
  bus::Clock::time_point touched_{};  // the folders, last
  bool ending_ = false;
};

}  // namespace hecaton::services
