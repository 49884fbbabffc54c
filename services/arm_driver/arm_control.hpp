#pragma once
/// Controls a device in each period of the driver. No network, no clock.

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
  double command_timeout = 0.0;           ///< [s] silence of commands, or of the device, after which the arm stops
  std::chrono::nanoseconds period{0};     ///< of the driver's loop
  std::chrono::nanoseconds valid_for{0};  ///< the device stops by itself without a set-point for this long
};

/// Checks and interpolates commands, stops the arm when commands cease or the cell mode holds it, and explains why the
/// arm stands. Each period consists of read(), any number of set_hold(), observe_lease() and command(), then write().
/// For one thread.
class ArmControl {
 public:
  using Clock = device::Clock;

  /// The device must outlive it. The destructor stops and deactivates the device.
  ArmControl(ArmControlSetup setup, device::ArmDevice& device);
  ~ArmControl();
  ArmControl(const ArmControl&) = delete;
  ArmControl& operator=(const ArmControl&) = delete;

  /// Reads the device's state at `now`. Configures and activates the device when possible.
  void read(Clock::time_point now);
  /// Why the cell mode holds the arm; empty: the arm may run.
  void set_hold(std::optional<msg::Cause> hold);
  /// See CommandGate.
  void observe_lease(const ArmLease& lease) { gate_.observe_lease(lease); }
  /// Follows the command when it is acceptable and the arm may run. Stops the arm when it is too far from the
  /// set-point.
  Judgement command(const msg::ArmCommand& command);
  /// Sends the device its next set-point.
  void write();

  [[nodiscard]] msg::ArmMode mode() const;
  /// Why the arm brakes, stands or has failed; CAUSE_NONE while it follows commands.
  [[nodiscard]] msg::Cause cause() const;
  /// Measured joint positions and velocities; empty until the device has measured any.
  [[nodiscard]] const planner::JointState& measured() const { return state_.measured; }
  [[nodiscard]] Clock::time_point measured_at() const { return measured_at_; }
  /// Time since the last accepted command, or since the first period [s].
  [[nodiscard]] double command_age() const { return std::chrono::duration<double>(now_ - accepted_at_).count(); }
  [[nodiscard]] const CommandGate& gate() const { return gate_; }

 private:
  /// The device's; unconfigured also after a failure.
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
  Clock::time_point retry_at_;  ///< when a failed device is configured again
  CommandGate gate_;
  planner::SetPointInterpolator interpolator_;
  Clock::time_point now_;           ///< of the last read()
  Clock::time_point reference_at_;  ///< the instant of the interpolator's reference
  Clock::time_point accepted_at_;
  bool commanded_ = false;             ///< a command has been accepted
  bool ran_ = false;                   ///< the arm has followed a command
  std::optional<msg::Cause> hold_;     ///< of the cell mode
  std::optional<msg::Cause> refusal_;  ///< of the last command when it was refused
};

}  // namespace hecaton::services
