#pragma once
/// The planner of one arm on the bus: states in, one command a period out, and an answer to every goal. On the arm's
/// standby host it does the same without commanding and answering, until it is put in charge.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/planner/explain.hpp"
#include "services/planner/failover.hpp"
#include "services/planner/goal_manager.hpp"
#include "services/planner/goal_resolver.hpp"
#include "services/planner/live_planner.hpp"
#include "services/planner/planner_topics.hpp"
#include "services/planner/search_threads.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"

namespace hecaton::services {

class PlannerService {
 public:
  /// `arm`: index in the cell. Throws std::runtime_error with a sentence when the bus cannot be joined.
  PlannerService(const config::CellFile& file, int arm, const ServiceOptions& options, const ShutdownSignal& shutdown);

  /// Until the process is to end.
  void run();

 private:
  using Clock = std::chrono::steady_clock;
  /// Which of the planner's other threads does not answer, in a sentence.
  struct HangingThreads {
    std::optional<std::string> resolver;  ///< goals cannot be resolved
    std::optional<std::string> any;
  };

  /// Of this planner among those of its arm.
  struct Place {
    std::string arm, node, host;
    bool first = true;
    bool alone = true;
  };
  [[nodiscard]] static Place place_of(const config::CellFile& file, int arm, const std::string& host);

  PlannerService(const config::CellFile& file, int arm, const ServiceOptions& options, const ShutdownSignal& shutdown,
                 const Place& place);

  void run_period(Clock::time_point now);
  void look_at_threads(Clock::time_point now);
  void handle_goals(Clock::time_point now);
  void plan(Clock::time_point now);
  void send_command(Clock::time_point now);
  void publish_statuses(Clock::time_point now);
  void beat(Clock::time_point now);

  bus::Mailbox mailbox_, modes_mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  PlannerSubscriptions subscriptions_;
  PlannerPublishers publishers_;
  PeriodicLoop loop_;
  FailoverParticipant failover_;
  GoalManager goals_;
  GoalResolver resolver_;
  LivePlanner planner_;
  SearchThreads searches_;
  ProgressReporter reporter_;
  std::optional<msg::Cause> hold_;  ///< why the arm must not move
  HangingThreads hanging_;
};

}  // namespace hecaton::services
