#pragma once
/// What a planner knows of the cell's arms from their drivers' messages, with ages on this process's clock.

#include <chrono>
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
#include "services/planner/sender_clock.hpp"
#include "services/runtime/cell_mode.hpp"

namespace hecaton::services {

class ArmView {
 public:
  using Clock = std::chrono::steady_clock;

  struct Heard {
    planner::JointVector q;   ///< [rad | m]
    planner::JointVector qd;  ///< [rad/s | m/s]
    msg::ArmMode mode = msg::ArmMode::ARM_STARTING;
    msg::Cause cause;  ///< why it does not follow commands
    std::uint64_t term = 0;
    std::uint64_t command_sequence = 0;
    double command_age = 0.0;   ///< of the last command that its driver accepted [s]
    ArmLease mandate;           ///< that its driver goes by
    std::int64_t stamp_ns = 0;  ///< on its driver's clock
    std::uint64_t sequence = 0;
    bus::EndpointId writer;
    Clock::time_point at;  ///< when it was true, on this process's clock
    SenderClock clock;     ///< of its writer
  };

  /// `self`: index of the own arm.
  ArmView(const planner::Cell& cell, int self);

  /// A sentence when the message cannot be used; so it is for arms of other cells.
  std::optional<std::string> apply(const msg::ArmState& state, const bus::EndpointId& writer,
                                   Clock::time_point received);

  /// Where an arm is under way to, as its planner says. A sentence when the message cannot be used.
  std::optional<std::string> apply(const msg::GoalStatus& status);

  /// The coupled plan that an arm proposes, and the one that it has joined. A sentence when the message cannot be used.
  /// It counts only while the arm's driver follows commands of the planner that published it: a planner that died
  /// cannot withdraw it.
  std::optional<std::string> apply(const msg::CoupledPlan& plan);
  std::optional<std::string> apply(const msg::CoupledPlanProgress& progress);

  [[nodiscard]] const std::optional<Heard>& arm(int index) const { return heard_[index]; }
  /// Of its last state [s]: since it arrived and what it was delayed; infinite before the first.
  [[nodiscard]] double age(int index, Clock::time_point now) const;
  /// The supervisor says that the arm was lost, and the arm itself says nothing else. Whoever does not hear the
  /// supervisor either knows nothing: it may itself be who was lost.
  [[nodiscard]] bool lost(int index, Clock::time_point now, const CellModeView& mode) const;
  /// One per arm. An arm takes its share of avoiding (`plans`) while its drive follows commands and nobody holds it;
  /// one that was lost stands somewhere in its rest region.
  [[nodiscard]] std::span<const planner::ArmObservation> observe(Clock::time_point now, const CellModeView& mode);

 private:
  /// −1: there is none of this name.
  [[nodiscard]] int index_of(const std::string& name) const;
  void observe_lost(int index, const msg::LostArm& lost);
  /// What one planner of an arm has said last of coupled plans.
  struct Said {
    std::string planner;  ///< its node
    planner::CoupledPlanProgress progress;
    std::shared_ptr<const planner::CoupledPlan> proposal;
  };
  [[nodiscard]] Said& said_by(int arm, const std::string& planner);
  /// What counts of that: the words of the planner that commands the arm, while the arm is on its way. Null: nothing.
  [[nodiscard]] const Said* company_of(int arm) const;

  int self_;
  double state_age_limit_;  ///< [s]
  std::vector<std::string> names_;
  std::vector<int> joints_;
  std::vector<planner::JointLimits> limits_;
  std::vector<std::optional<Heard>> heard_;
  std::vector<planner::ArmObservation> observations_;
  std::vector<std::vector<Said>> said_;  ///< by arm; who spoke last is last
  std::vector<std::string> goals_;       ///< the one that each arm is under way to; empty: none
};

}  // namespace hecaton::services
