#pragma once
/// The planner of one arm on the bus: its topics and its loop.

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/world.h>

#include "planner/local/observation.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/planner/failover.hpp"
#include "services/planner/goal_manager.hpp"
#include "services/planner/goal_resolver.hpp"
#include "services/planner/live_planner.hpp"
#include "services/planner/motion_publisher.hpp"
#include "services/planner/progress_reporter.hpp"
#include "services/planner/search_threads.hpp"
#include "services/planner/tick_publisher.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"

namespace hecaton::services {

/// Topics that a planner subscribes to.
class PlannerSubscriptions {
 public:
  /// `planner`: for which the messages are. All endpoints notify `mailbox`, which must outlive the object, as must
  /// `participant`.
  PlannerSubscriptions(bus::Participant& participant, bus::Mailbox& mailbox, const LivePlanner& planner);

  /// Passes all received messages except goals to `planner`, and logs messages that are invalid. Returns the valid goal
  /// statuses, of all arms.
  [[nodiscard]] std::vector<msg::GoalStatus> update(LivePlanner& planner);
  /// Goals received since the last call, of all arms.
  [[nodiscard]] std::vector<msg::Goal> take_goals();

 private:
  /// Makes another reader if the planner has other neighbours.
  void follow_neighbours(const LivePlanner& planner);
  void update_obstacles(ObstacleView& obstacles);
  void report_unusable(const std::optional<std::string>& unusable);

  std::string arm_;
  bus::Participant& participant_;
  bus::Mailbox& mailbox_;
  std::vector<int> neighbours_;
  bus::Reader<msg::ArmState> arm_states_;  ///< of neighbours_
  bus::Reader<msg::ObstacleShapes> obstacle_shapes_;
  bus::Reader<msg::ObstacleStates> obstacle_states_;
  bus::Reader<msg::RangeScan> scans_;
  bus::Reader<msg::Goal> goals_;
  bus::Reader<msg::GoalStatus> statuses_;
  bus::Reader<msg::CoupledPlan> proposals_;
  bus::Reader<msg::CoupledPlanProgress> progress_;
  std::optional<std::string> last_warning_;  ///< is not logged again
};

/// Publishes the proposal and the progress of an arm in coupled plans (docs/explanation/0015-coupled-plans.md).
class CoordinationPublisher {
 public:
  /// `arms`: names of the cell's arms; `self`: index of the own arm; `node`: of the planner.
  CoordinationPublisher(bus::Participant& participant, std::vector<std::string> arms, int self, std::string node);

  /// Call it in every period in which this planner commands its arm. Writes what has changed. In the first period it
  /// writes both, because an earlier planner of the arm may have ended during a plan and other arms wait for this one.
  void publish(const std::shared_ptr<const planner::CoupledPlan>& proposal,
               const planner::CoupledPlanProgress& progress);
  /// Call it when another planner commands the arm.
  void resign() { begun_ = false; }

 private:
  void write_proposal();
  void write_progress();

  std::vector<std::string> arms_;
  int self_;
  std::string node_;
  bus::Writer<msg::CoupledPlan> proposal_writer_;
  bus::Writer<msg::CoupledPlanProgress> progress_writer_;
  std::shared_ptr<const planner::CoupledPlan> proposal_;  ///< as published
  planner::CoupledPlanProgress progress_;                 ///< as published
  bool begun_ = false;                                    ///< both were published since this planner took charge
};

/// Topics that a planner publishes.
struct PlannerPublishers {
  bus::Writer<msg::ArmCommand> commands;
  bus::Writer<msg::GoalStatus> statuses;
  CoordinationPublisher coordination;
  HeartbeatPublisher heartbeat;
  TickPublisher ticks;
  MotionPublisher motions;
};

/// The planner of one arm as a service: it receives states, publishes one command per control period, and answers every
/// goal. A standby planner does the same without publishing commands and goal statuses until it is put in charge.
class PlannerService {
 public:
  /// `arm`: index in the cell. Throws std::runtime_error with a sentence when the domain cannot be joined.
  PlannerService(const config::CellFile& file, int arm, const ServiceOptions& options, const ShutdownSignal& shutdown);

  /// Runs until `shutdown` is requested.
  void run();

 private:
  using Clock = std::chrono::steady_clock;
  /// Sentences about background threads that do not answer; empty: they do.
  struct StalledThreads {
    std::optional<std::string> resolver;  ///< goals cannot be resolved
    std::optional<std::string> any;
  };

  /// This planner among the planners of its arm.
  struct Place {
    std::string arm, node, host;
    bool first = true;  ///< it is not the standby planner
    bool alone = true;  ///< the arm has no other planner
  };
  [[nodiscard]] static Place place_of(const config::CellFile& file, int arm, const std::string& host);

  PlannerService(const config::CellFile& file, int arm, const ServiceOptions& options, const ShutdownSignal& shutdown,
                 const Place& place);

  void run_period(Clock::time_point now);
  void check_threads(Clock::time_point now);
  void handle_goals(Clock::time_point now);
  void end_goals_without_device(Clock::time_point now);
  void plan(Clock::time_point now);
  void send_command(Clock::time_point now);
  void publish_statuses(Clock::time_point now);
  void publish_heartbeat(Clock::time_point now);

  bus::Mailbox mailbox_, modes_mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  LivePlanner planner_;
  PlannerSubscriptions subscriptions_;
  PlannerPublishers publishers_;
  PeriodicLoop loop_;
  FailoverParticipant failover_;
  GoalManager goals_;
  GoalResolver resolver_;
  SearchThreads searches_;
  ProgressReporter reporter_;
  std::optional<msg::Cause> hold_;  ///< why the arm must not move
  bool held_for_device_ = false;    ///< in the last period
  StalledThreads stalled_;
};

}  // namespace hecaton::services
