#pragma once
/// The topics of one arm's planner: what it subscribes to, and what it publishes.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/world.h>

#include "planner/local/coupled_plan.hpp"
#include "services/bus/endpoint.hpp"
#include "services/planner/live_planner.hpp"
#include "services/runtime/pulse.hpp"

namespace hecaton::services {

class PlannerSubscriptions {
 public:
  /// `arm`: of the planner. All endpoints announce arrivals in `mailbox`.
  PlannerSubscriptions(bus::Participant& participant, bus::Mailbox& mailbox, std::string arm);

  /// Hands everything but goals that has arrived to `planner`; messages that cannot be used are logged. Returns the
  /// goal statuses that can be used, of all arms.
  [[nodiscard]] std::vector<msg::GoalStatus> update(LivePlanner& planner);
  /// Goals that have arrived, of all arms. They wait until they are taken.
  [[nodiscard]] std::vector<msg::Goal> take_goals();

 private:
  void update_obstacles(ObstacleView& obstacles);
  void complain(const std::optional<std::string>& unusable);

  std::string arm_;
  bus::Mailbox& mailbox_;
  bus::Reader<msg::ArmState> arm_states_;
  bus::Reader<msg::ObstacleShapes> obstacle_shapes_;
  bus::Reader<msg::ObstacleStates> obstacle_states_;
  bus::Reader<msg::RangeScan> scans_;
  bus::Reader<msg::Goal> goals_;
  bus::Reader<msg::GoalStatus> statuses_;
  bus::Reader<msg::CoupledPlan> proposals_;
  bus::Reader<msg::CoupledPlanProgress> progress_;
  std::optional<std::string> complaint_;  ///< logged last
};

/// A planner's part in coupled plans, as other planners see it (docs/design/0017-coupled-plans.md).
class CoordinationPublisher {
 public:
  /// `arms`: names of the cell's arms; `self`: index of the own one; `node`: of the planner.
  CoordinationPublisher(bus::Participant& participant, std::vector<std::string> arms, int self, std::string node);

  /// In every period in which this planner commands its arm: writes what has changed, and both when it begins. The
  /// planner before it, under this name or another, may have died during a plan, and other arms wait for this one.
  void publish(const std::shared_ptr<const planner::CoupledPlan>& proposal,
               const planner::CoupledPlanProgress& progress);
  /// Another planner commands the arm, and publishes its part.
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
  bool begun_ = false;                                    ///< both were published since this planner commands the arm
};

struct PlannerPublishers {
  bus::Writer<msg::ArmCommand> commands;
  bus::Writer<msg::GoalStatus> statuses;
  CoordinationPublisher coordination;
  Pulse heartbeat;
};

}  // namespace hecaton::services
