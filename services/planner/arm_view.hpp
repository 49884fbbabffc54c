#pragma once
/// The cell's arms as a planner knows them from messages, with ages on the clock of this process.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/goal.h>

#include "planner/cell.hpp"
#include "planner/local/observation.hpp"
#include "services/bus/mailbox.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/sender_clock.hpp"

namespace hecaton::services {

/// States, goals and coupled plans of all arms, from messages of their drivers and planners. For one thread.
class ArmView {
 public:
  using Clock = std::chrono::steady_clock;

  struct ReceivedState {
    planner::JointVector q;   ///< [rad | m]
    planner::JointVector qd;  ///< [rad/s | m/s]
    msg::ArmMode mode = msg::ArmMode::ARM_STARTING;
    msg::Cause cause;  ///< why the drive does not follow commands
    std::uint64_t term = 0;
    std::uint64_t command_sequence = 0;
    double command_age = 0.0;     ///< of the last command that the driver accepted, at the measurement; may be < 0 [s]
    double tracking_delay = 0.0;  ///< lag behind the set-points [s]
    double speed_scaling = 1.0;   ///< executed share of the set-points' speed, 0 to 1
    ArmLease lease;               ///< in force at the driver
    std::int64_t stamp_ns = 0;    ///< on the driver's clock
    std::uint64_t sequence = 0;
    bus::EndpointId writer;
    Clock::time_point at;  ///< when it was true, on this process's clock
    SenderClock clock;     ///< of its writer
    /// Of the joints outside the chain; empty: anywhere in their ranges.
    std::vector<planner::MotionRange> outside = {};
    bool foreign = false;  ///< others move it, or did when its device failed
  };

  /// `self`: index of the own arm. Every arm is a neighbour.
  ArmView(const planner::Cell& cell, int self);

  /// The arms whose states count from now on, ascending. A new one is unknown until its next state.
  void set_neighbours(std::vector<int> neighbours);
  [[nodiscard]] const std::vector<int>& neighbours() const { return neighbours_; }
  [[nodiscard]] bool is_neighbour(int index) const;

  // Each apply() returns a sentence when the message is invalid; it then has no effect. Messages about arms that the
  // cell does not have are invalid.

  std::optional<std::string> apply(const msg::ArmState& state, const bus::EndpointId& writer,
                                   Clock::time_point received);

  /// The goal of an arm.
  std::optional<std::string> apply(const msg::GoalStatus& status);

  /// The coupled plan that an arm proposes, and the one that it has joined. Both are valid only while the arm's driver
  /// follows commands of the planner that published them: a dead planner cannot withdraw them.
  std::optional<std::string> apply(const msg::CoupledPlan& plan);
  std::optional<std::string> apply(const msg::CoupledPlanProgress& progress);

  [[nodiscard]] const std::optional<ReceivedState>& arm(int index) const { return received_[index]; }
  /// Where the joints outside the chain are, of an arm whose state is fresh; else their ranges.
  [[nodiscard]] const std::vector<planner::MotionRange>& outside(int index, Clock::time_point now) const;
  /// Age of the last state of an arm, with its delay [s]; infinite before the first.
  [[nodiscard]] double age(int index, Clock::time_point now) const;
  /// The supervisor reports the arm as lost, and this planner has no fresh state of it. False without a fresh cell
  /// mode: this planner itself may be cut off.
  [[nodiscard]] bool lost(int index, Clock::time_point now, const CellModeView& mode) const;
  /// One observation per arm, at `now`. An arm avoids collisions (`plans`) while its drive follows commands and it is
  /// not held. A lost arm is at rest anywhere in its reachable stop set. An arm that is no neighbour counts as at rest
  /// at home: it does not come near the own arm in any posture.
  [[nodiscard]] std::span<const planner::ArmObservation> observe(Clock::time_point now, const CellModeView& mode);

 private:
  /// −1: no such arm.
  [[nodiscard]] int index_of(const std::string& name) const;
  void observe_lost(int index, const msg::LostArm& lost);
  void observe_far(int index);
  /// The last messages of one planner of an arm about coupled plans.
  struct Coordination {
    std::string planner;  ///< its node
    planner::CoupledPlanProgress progress;
    std::shared_ptr<const planner::CoupledPlan> proposal;
  };
  [[nodiscard]] Coordination& coordination_of(int arm, const std::string& planner);
  /// The entry of the planner that commands the arm, while the arm is moving by commands. Null: none.
  [[nodiscard]] const Coordination* active_coordination(int arm) const;

  int self_;
  double state_age_limit_;  ///< [s]
  std::vector<std::string> names_;
  std::vector<int> joints_;
  std::vector<planner::JointLimits> limits_;
  std::vector<planner::JointVector> homes_;
  std::vector<int> neighbours_;
  std::vector<std::vector<planner::MotionRange>> ranges_;  ///< of the joints outside the chain, by arm
  std::vector<std::optional<ReceivedState>> received_;
  std::vector<planner::ArmObservation> observations_;
  std::vector<std::optional<Clock::time_point>> planned_at_;  ///< when each arm was last known to plan
  std::vector<std::vector<Coordination>> coordination_;       ///< by arm; the planner of the last message is last
  std::vector<std::string> goals_;                            ///< identifier of each arm's goal; empty: none
};

}  // namespace hecaton::services
