#pragma once
/// What the driver does with its device in a period: checks commands, interpolates them, stops the arm when they cease
/// or an order says so, and tells why the arm stands. No network, no clock.

#include <chrono>
#include <optional>
#include <string>

#include <idl/arm.h>

#include "services/arm_driver/command_gate.hpp"
#include "services/arm_driver/devices/arm_device.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {

struct ArmControlSetup {
  std::string arm;
  planner::JointLimits limits;
  double command_timeout = 0.0;           ///< [s]: silence of commands, or of the device, after which the arm stops
  std::chrono::nanoseconds period{0};     ///< of the driver's loop
  std::chrono::nanoseconds valid_for{0};  ///< the device stops by itself when no set-point follows in this time
};

/// In each period: read(), then any number of order(), saw() and command(), then write().
class ArmControl {
 public:
  using Clock = device::Clock;

  /// The device must outlive it. It is stopped and deactivated in the end.
  ArmControl(ArmControlSetup setup, device::ArmDevice& device);
  ~ArmControl();
  ArmControl(const ArmControl&) = delete;
  ArmControl& operator=(const ArmControl&) = delete;

  /// The device's state at `now`. Configures and activates it as far as it lets itself.
  void read(Clock::time_point now);
  /// Why the cell mode holds the arm; nothing: the arm may run.
  void order(std::optional<msg::Cause> hold);
  /// A lease that exists, see CommandGate.
  void saw(const ArmLease& lease) { gate_.saw(lease); }
  /// Follows the command when it is acceptable and the order lets it. Stops when the arm is too far from it.
  Judgement command(const msg::ArmCommand& command);
  /// Sends the device its next set-point.
  void write();

  [[nodiscard]] msg::ArmMode mode() const;
  /// Why the arm brakes, stands or has failed; CAUSE_NONE while it follows commands.
  [[nodiscard]] msg::Cause cause() const;
  /// Measured. Empty when the device has never measured anything.
  [[nodiscard]] const planner::JointState& measured() const { return state_.measured; }
  [[nodiscard]] Clock::time_point measured_at() const { return measured_at_; }
  /// Since the last accepted command, or since the first period [s].
  [[nodiscard]] double command_age() const { return std::chrono::duration<double>(now_ - accepted_at_).count(); }
  [[nodiscard]] const CommandGate& gate() const { return gate_; }

 private:
  /// Of the device: unconfigured also after a failure.
  enum class Phase { kUnconfigured, kInactive, kActive };

  [[nodiscard]] bool configured();
  [[nodiscard]] std::optional<std::string> unusable_state() const;
  void fail(const std::string& text);
  void release();
  void stop(const planner::JointState& from);
  void interpolate();
  [[nodiscard]] const planner::JointState& continues_from() const;

  ArmControlSetup setup_;
  device::ArmDevice& device_;
  Phase phase_ = Phase::kUnconfigured;
  device::DeviceState state_;
  Clock::time_point measured_at_;
  Clock::time_point retry_at_;  ///< when a device that failed is configured again
  CommandGate gate_;
  planner::SetPointInterpolator interpolator_;
  Clock::time_point now_;           ///< of the last read()
  Clock::time_point reference_at_;  ///< the instant of the interpolator's reference
  Clock::time_point accepted_at_;
  bool commanded_ = false;             ///< a command was ever accepted
  bool ran_ = false;                   ///< it ever followed a command
  std::optional<msg::Cause> hold_;     ///< of the cell mode
  std::optional<msg::Cause> refusal_;  ///< of the last command, if it was refused
};

}  // namespace hecaton::services
