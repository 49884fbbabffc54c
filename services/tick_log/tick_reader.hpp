#pragma once
/// The inputs of a control period from the messages of a recording.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <idl/planner.h>

#include "planner/arm_planner/arm_planner.hpp"
#include "planner/cell.hpp"

namespace hecaton::services {

/// Reads the messages of one planner, one after the other. It checks all sizes and indices, since messages come from
/// files. For one thread.
class TickReader {
 public:
  /// `cell` must outlive the reader. `self`: index of the planner's arm.
  TickReader(const planner::Cell& cell, int self);

  /// Takes the next message. The first one must be a snapshot, and so must one that follows a missing message. Returns
  /// a sentence about a message that cannot be used; then the next one must be a snapshot.
  [[nodiscard]] std::optional<std::string> take(const msg::PlannerTick& message);

  // Of the last message, until the next one.
  [[nodiscard]] const planner::PeriodEvents& events() const { return events_; }
  /// Precondition: the message has a set-point.
  [[nodiscard]] const planner::PeriodInputs& inputs() const { return inputs_; }

  /// A new planner in the state before this message. Empty: the message's options or memory are not those of this
  /// program. Precondition: the message is a snapshot.
  [[nodiscard]] std::unique_ptr<planner::ArmPlanner> planner(const msg::PlannerTick& snapshot) const;

 private:
  using Error = std::optional<std::string>;
  [[nodiscard]] Error take_events(const msg::PlannerTick& message);
  [[nodiscard]] Error take_inputs(const msg::PlannerTick& message);
  [[nodiscard]] Error take_obstacles(const msg::PlannerTick& message);
  [[nodiscard]] Error take_arms(const msg::PlannerTick& message);
  [[nodiscard]] Error take_obstacle_states(const msg::PlannerTick& message);
  /// `joints`: expected size. Empty values are allowed if `may_be_empty`.
  [[nodiscard]] static bool read(const std::vector<double>& values, int joints, bool may_be_empty,
                                 planner::JointVector& q);
  [[nodiscard]] bool read(const msg::TickRoute& message, planner::RouteAnswer& answer) const;

  const planner::Cell& cell_;
  int self_;
  std::vector<int> joints_;  ///< of each arm
  std::vector<planner::ArmObservation> arms_;
  std::vector<world::ObstacleState> states_;
  std::size_t obstacles_ = 0;  ///< number of them
  std::vector<planner::RangeScan> scans_;
  planner::PeriodEvents events_;
  planner::PeriodInputs inputs_;
};

}  // namespace hecaton::services
