#pragma once
/// The planner of one arm in terms of messages: it collects the newest states with their ages, passes them to
/// ArmPlanner in each control period, and returns a command message. It has no endpoints, threads or clock.

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
#include "services/planner/environment_view.hpp"
#include "services/planner/goal_resolver.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/tick_log/tick_writer.hpp"

namespace hecaton::services {

/// The arm is held because an input is missing or too old, and not by an order or a fault.
[[nodiscard]] bool is_missing_input(const msg::Cause& hold);

/// For one thread.
class LivePlanner {
 public:
  using Clock = std::chrono::steady_clock;

  /// `self`: index of the arm in the cell. `node`: of the planner, for commands. `cell`: as planner::live_cell() gives
  /// it.
  LivePlanner(const planner::Cell& cell, int self, const std::string& node, const planner::ArmPlannerOptions& options);

  // Receive messages.
  [[nodiscard]] ArmView& arms() { return arms_; }
  /// The arms whose states the planner needs, ascending: the own arm and all that can come within the influence
  /// distance of it, with what both carry (docs/explanation/0023-neighbours.md). Changes when an arm grasps or releases
  /// a body.
  [[nodiscard]] const std::vector<int>& neighbours() const { return arms_.neighbours(); }
  [[nodiscard]] std::vector<std::string> neighbour_names() const;
  [[nodiscard]] ObstacleView& obstacles() { return obstacles_; }
  /// Returns a sentence when the scan is invalid.
  std::optional<std::string> apply(const msg::RangeScan& scan, const bus::EndpointId& writer,
                                   Clock::time_point received);

  /// Why the arm must not move now; empty: it may.
  [[nodiscard]] std::optional<msg::Cause> hold(Clock::time_point now, const CellModeView& mode) const;
  /// Why goals cannot be resolved yet; empty: they can.
  [[nodiscard]] std::optional<msg::Cause> cannot_resolve() const;
  /// `goal` with the state that is needed to resolve it. `begins`: this planner is in charge. Precondition:
  /// cannot_resolve() is empty.
  [[nodiscard]] GoalQuestion question(const msg::Goal& goal, Clock::time_point now, bool begins = true);

  struct OldestInput {
    double age = 0.0;  ///< [s]; infinite: none received
    std::string topic_and_key;
    msg::CauseKind kind = msg::CauseKind::CAUSE_NONE;  ///< of the cause if it is missing or too old
  };
  /// The oldest input that the planner needs. Lost arms do not count: the planner avoids their reachable stop set.
  [[nodiscard]] OldestInput oldest_input(Clock::time_point now, const CellModeView& mode) const;

  struct PeriodContext {
    Clock::time_point now;  ///< beginning of the period
    double missed = 0.0;    ///< duration of skipped control periods [s]
    const CellModeView& mode;
    std::uint64_t term = 0;  ///< for commands
    bool commands = false;   ///< this planner is in charge of the arm
    bool continues = false;  ///< it also was in the last period, so the drive follows its set-points
    bool hold = false;
    std::optional<planner::GoalChange> goal = {};
    /// Gets inputs and set-point of the period, with the planner's memory if `snapshot`; null: no recorder receives it.
    TickWriter* ticks = nullptr;
    bool snapshot = false;
  };
  struct PlannedPeriod {
    planner::PeriodInputs inputs;  ///< valid until the next period
    planner::TickResult result;
  };
  /// Plans one control period. Empty without a fresh state of the arm: no set-point is safe without its position, and
  /// the driver brakes when commands stop. A planner that begins also needs an arm that stands, or a newer state.
  [[nodiscard]] std::optional<PlannedPeriod> step(const PeriodContext& context, planner::SearchExecutor& searches);
  /// The command of the last period, if its inputs have a number. The caller sets the stamp.
  [[nodiscard]] msg::ArmCommand& command() { return command_; }
  /// Starts searches for the next periods. Call it after the command was sent.
  void plan_ahead(const PlannedPeriod& period, planner::SearchExecutor& searches);

  /// Records the time from the beginning of a period until its command was sent. The planner assumes the longest one of
  /// the recent past for the next commands.
  void note_reaction(Clock::duration taken);
  [[nodiscard]] Clock::duration reaction() const { return reaction_; }

  [[nodiscard]] const planner::ArmPlanner& planner() const { return planner_; }
  [[nodiscard]] const std::optional<ArmView::ReceivedState>& own_arm() const { return arms_.arm(self_); }
  [[nodiscard]] const std::string& name() const { return planner_.controller().geometry().own_arm().name; }
  [[nodiscard]] double state_age_limit() const { return state_age_limit_; }

 private:
  [[nodiscard]] bool has_fresh_own_state(Clock::time_point now) const;
  [[nodiscard]] bool is_braked_first(const PeriodContext& context) const;
  [[nodiscard]] std::optional<msg::Cause> missing_environment(Clock::time_point now) const;
  [[nodiscard]] std::uint64_t next_number(const PeriodContext& context);
  /// Of the planner's present geometry.
  [[nodiscard]] std::vector<int> find_neighbours() const;
  /// Joins the world's obstacles with what the arms have outside their chains.
  void update_scene(Clock::time_point now);
  /// States of scene_, with their ages at `now`. Valid until the next call.
  [[nodiscard]] std::span<const world::ObstacleState> states(Clock::time_point now);
  void log_events(const PeriodContext& context, const planner::PeriodEvents& events) const;

  int self_;
  double state_age_limit_;     ///< [s]
  double influence_distance_;  ///< the largest of all arms [m]
  bool sensor_only_;           ///< obstacles are known by the arm's sensors only
  ArmView arms_;
  ObstacleView obstacles_;
  SensorView sensors_;
  std::vector<planner::RangeScan> scans_;  ///< since the last period
  std::vector<planner::Arm> arms_of_cell_;
  /// The world's obstacles, and as the last ones the bodies that joints outside the chains move; null: none known yet.
  planner::SharedObstacles scene_;
  planner::SharedObstacles joined_;                        ///< the world's part of scene_
  std::vector<std::vector<planner::MotionRange>> places_;  ///< of the joints outside the chains in scene_, by arm
  std::vector<world::ObstacleState> states_;
  planner::SharedObstacles planned_with_;  ///< as last given to planner_
  planner::ArmPlannerOptions options_;
  planner::ArmPlanner planner_;
  Clock::duration reaction_{};  ///< longest recent time from the beginning of a period until its command was sent
  std::uint64_t sequence_ = 0;  ///< number of the last command
  msg::ArmCommand command_;     ///< reused every period
};

}  // namespace hecaton::services
