#pragma once
/// The planner of one arm above the bus: messages in, one command message a period out. It keeps what the planner knows
/// of its cell, with ages on this process's clock, and hands it to ArmPlanner as values. No endpoints, no threads: time
/// comes from outside, and searches run elsewhere.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/cause.h>

#include "planner/arm_planner/arm_planner.hpp"
#include "planner/cell.hpp"
#include "services/planner/arm_view.hpp"
#include "services/planner/goal_resolver.hpp"
#include "services/planner/obstacle_view.hpp"
#include "services/planner/sensor_view.hpp"
#include "services/runtime/cell_mode.hpp"

namespace hecaton::services {

/// Another cause holds the arm than a person or a fault: an input is missing or too old.
[[nodiscard]] bool is_missing_input(const msg::Cause& hold);

class LivePlanner {
 public:
  using Clock = std::chrono::steady_clock;

  /// `self`: index of the arm. `node`: the planner's, for its commands.
  LivePlanner(const planner::Cell& cell, int self, const std::string& node, const planner::ArmPlannerOptions& options);

  // Messages go here.
  [[nodiscard]] ArmView& arms() { return arms_; }
  [[nodiscard]] ObstacleView& obstacles() { return obstacles_; }
  /// A sentence when the scan cannot be used.
  std::optional<std::string> apply(const msg::RangeScan& scan, const bus::EndpointId& writer,
                                   Clock::time_point received);

  /// Why the arm must not move now; empty when it may.
  [[nodiscard]] std::optional<msg::Cause> hold(Clock::time_point now, const CellModeView& mode) const;
  /// Why goals cannot be resolved yet; empty when they can.
  [[nodiscard]] std::optional<msg::Cause> cannot_resolve() const;
  /// `goal` with all that is needed to resolve it; only when cannot_resolve() is empty.
  [[nodiscard]] GoalQuestion question(const msg::Goal& goal, Clock::time_point now);

  struct OldestInput {
    double age = 0.0;  ///< [s]; infinite: never received
    std::string topic_and_key;
    msg::CauseKind kind = msg::CauseKind::CAUSE_NONE;  ///< that it is missing or too old
  };
  /// Of all inputs that the planner needs; lost arms do not count, the planner works around them.
  [[nodiscard]] OldestInput oldest_input(Clock::time_point now, const CellModeView& mode) const;

  struct PeriodContext {
    Clock::time_point now;  ///< when the period began
    double missed = 0.0;    ///< control periods that passed unused [s]
    const CellModeView& mode;
    std::uint64_t term = 0;  ///< for commands
    bool commands = false;   ///< this planner is in charge
    bool continues = false;  ///< it also was in the period before: the drive follows its set-points
    bool hold = false;
    std::optional<planner::GoalChange> goal = {};
  };
  struct PlannedPeriod {
    planner::PeriodInputs inputs;  ///< valid until the next period
    planner::TickResult result;
  };
  /// One control period. Empty while the driver is silent: without the arm's position no set-point is sound, and its
  /// driver stops it by itself.
  [[nodiscard]] std::optional<PlannedPeriod> step(const PeriodContext& context, planner::SearchExecutor& searches);
  /// The command of a period whose inputs have a number; the stamp is left to the caller.
  [[nodiscard]] msg::ArmCommand& command() { return command_; }
  /// After the command has been sent.
  void plan_ahead(const PlannedPeriod& period, planner::SearchExecutor& searches);

  /// A period took so long. The planner expects that commands are sent as late as the latest of the recent past: a
  /// machine that stalled will stall again.
  void note_reaction(Clock::duration taken);
  [[nodiscard]] Clock::duration reaction() const { return reaction_; }

  [[nodiscard]] const planner::ArmPlanner& planner() const { return planner_; }
  [[nodiscard]] const std::optional<ArmView::Heard>& own_arm() const { return arms_.arm(self_); }
  [[nodiscard]] const std::string& name() const { return planner_.controller().geometry().own_arm().name; }
  [[nodiscard]] double state_age_limit() const { return state_age_limit_; }

 private:
  [[nodiscard]] bool hears_own_arm(Clock::time_point now) const;
  [[nodiscard]] std::optional<msg::Cause> missing_obstacles(Clock::time_point now) const;
  [[nodiscard]] std::uint64_t next_number(const PeriodContext& context);

  int self_;
  double state_age_limit_;  ///< [s]
  bool sensor_only_;        ///< the arm knows no obstacle but what its sensors measure
  ArmView arms_;
  ObstacleView obstacles_;
  SensorView sensors_;
  std::vector<planner::RangeScan> scans_;  ///< since the last period
  planner::SharedObstacles planned_with_;  ///< as the planner has them
  planner::ArmPlanner planner_;
  Clock::duration reaction_{};  ///< from the beginning of a period until its command is sent, at most
  std::uint64_t sequence_ = 0;  ///< of the last command
  msg::ArmCommand command_;     ///< reused every period
};

}  // namespace hecaton::services
