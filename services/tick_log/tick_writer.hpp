#pragma once
/// The inputs and the set-point of each control period as messages, so that a recording can be recomputed bit by bit.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <idl/planner.h>

#include "planner/arm_planner/arm_planner.hpp"

namespace hecaton::services {

/// Makes the messages of one planner. Call begin() and then, if the period has a set-point, finish(). A message has
/// only what has changed since the message before: every message must be sent, or the next one be a snapshot. No clock,
/// no network. For one thread.
class TickWriter {
 public:
  /// A recording can be recomputed from the next snapshot on: one follows the other in this time [s].
  static constexpr double kSnapshotPeriod = 5.0;

  /// `arm`, `self`: name and index of the own arm.
  TickWriter(std::string arm, int self, std::string node);

  /// The planner before a period: recomputation can begin with the message of this period.
  struct Snapshot {
    std::vector<std::uint32_t> memory;        ///< ArmPlanner::save(); empty: the planner has just been built
    std::string program;                      ///< program_text()
    planner::ArmPlannerOptions options;       ///< of the planner
    planner::SharedObstacles obstacles = {};  ///< all of the cell; null: none known yet
  };
  /// Begins the message of a period. `events`: as passed to ArmPlanner::receive(). `stamp_ns`: beginning of the period.
  void begin(std::int64_t stamp_ns, const planner::PeriodEvents& events, const std::optional<Snapshot>& snapshot);
  /// Call it before begin() when the message of the period before was not sent. The next message needs a snapshot.
  void interrupt() { message_.sequence_number(0); }
  /// `inputs`, `result`: of ArmPlanner::step() in this period.
  void finish(const planner::PeriodInputs& inputs, const planner::TickResult& result);

  /// The message of the last period, until the next begin().
  [[nodiscard]] const msg::PlannerTick& message() const { return message_; }

 private:
  void write_arms(std::span<const planner::ArmObservation> arms);
  void write_obstacle_states(std::span<const world::ObstacleState> states);

  int self_;
  msg::PlannerTick message_;
  // As in the messages so far.
  std::vector<world::ObstacleState> states_;
  std::vector<std::shared_ptr<const planner::CoupledPlan>> proposals_;
};

}  // namespace hecaton::services
