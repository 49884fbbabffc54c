#pragma once
/// The agent of a host: starts the services that the cell file places there, tells of every start and end within a
/// millisecond, restarts what died. What it started ends with it, however it ends; what that remembers is there for an
/// agent that takes its place, unless it was asked to end.

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include <idl/health.h>

#include "services/agent/keeper.hpp"
#include "services/agent/reachability_reporter.hpp"
#include "services/agent/service_manager.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/pulse.hpp"
#include "services/runtime/run_folder.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services {

struct AgentOptions {
  std::filesystem::path programs;  ///< folder of the services' executables
  std::filesystem::path logs;      ///< folder of their logs; empty: they log where the agent does
  bool restart = true;
  bool anew = false;  ///< what an agent that was killed has left is not used
};

class Agent {
 public:
  static constexpr std::chrono::seconds kPatience{2};  ///< with a service that was told to end, before it is killed

  /// Throws std::runtime_error with a sentence.
  Agent(const config::CellFile& file, const ServiceOptions& options, const AgentOptions& agent,
        ShutdownSignal& shutdown);
  ~Agent();
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  /// Until the process is to end and all services have ended.
  void run();

 private:
  void wait(bus::Clock::time_point until);
  void turn();
  void tell(const Incident& incident);
  void beat(bus::Clock::time_point now);
  void touch_folders(bus::Clock::time_point now);

  std::chrono::nanoseconds period_;
  ShutdownSignal& shutdown_;
  ServiceManager manager_;
  std::vector<RunFolder> folders_;  // one for each host that it stands for
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  bus::Writer<msg::ProcessEvent> events_;
  std::deque<Pulse> pulses_;  // of each of these hosts
  ReachabilityReporter reachability_;
  Keeper keeper_;
  LoopStatistics loop_;
  std::vector<pollfd> descriptors_;
  std::uint64_t sequence_ = 0;
  bus::Clock::time_point touched_{};
  bool ending_ = false;
};

}  // namespace hecaton::services
