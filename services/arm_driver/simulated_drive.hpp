#pragma once
/// A simulated arm behind its drive's interface: what it is told, what it does, and why it stands. No network, no
/// clock.

#include <cstdint>
#include <string>

#include <idl/arm.h>

#include "planner/simulation/arm_model.hpp"
#include "services/arm_driver/command_gate.hpp"
#include "services/runtime/cell_mode.hpp"

namespace hecaton::services {

class SimulatedDrive {
 public:
  /// At rest at `start`; stops by itself after `command_timeout` [s] without an accepted command.
  SimulatedDrive(planner::JointLimits limits, const planner::JointVector& start, double command_timeout);

  /// The order in force, from the cell mode. Anything but kRun stops the arm; `why` is told meanwhile.
  void order(msg::Mode order, const std::string& why);
  /// A mandate that exists, see CommandGate.
  void saw(const ArmLease& mandate) { gate_.saw(mandate); }
  /// Follows the command when it is acceptable and the order lets it; stops when the arm is too far from it.
  Verdict command(const msg::ArmCommand& command);
  /// Advances by dt [s].
  void step(double dt);

  [[nodiscard]] msg::ArmMode mode() const { return mode_; }
  /// Why it brakes or stands, a sentence; empty while it follows commands.
  [[nodiscard]] std::string reason() const;
  [[nodiscard]] double command_age() const { return command_age_; }  ///< since the last accepted one [s]
  [[nodiscard]] const planner::ArmModel& arm() const { return arm_; }
  [[nodiscard]] const CommandGate& gate() const { return gate_; }
  /// Why the last command was too far away, a sentence; empty when it was not.
  [[nodiscard]] const std::string& complaint() const { return complaint_; }
  [[nodiscard]] std::uint64_t too_far() const { return too_far_; }  ///< commands refused because the arm was too far

 private:
  planner::ArmModel arm_;
  CommandGate gate_;
  double command_timeout_;
  msg::Mode order_ = msg::Mode::MODE_HOLD;
  std::string why_;
  msg::ArmMode mode_ = msg::ArmMode::ARM_STARTING;
  bool commanded_ = false;
  double command_age_ = 0.0;
  std::string complaint_;  ///< of the last command when the arm was too far from it
  std::uint64_t too_far_ = 0;
};

}  // namespace hecaton::services
