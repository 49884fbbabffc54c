#pragma once
/// Controls a device in each period of the driver. No network, no clock.

#include <chrono>
#include <optional>
#include <string>

#include <idl/arm.h>

#include "services/arm_driver/command_gate.hpp"
#include "services/arm_driver/device_session.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {

struct ArmControlSetup {
  std::string arm;
  planner::JointLimits limits;
  double command_timeout = 0.0;            ///< [s] silence of commands, or of the device, after which the arm stops
  std::chrono::nanoseconds period{0};      ///< of the driver's loop
  std::chrono::nanoseconds valid_for{0};   ///< the device stops by itself without a set-point for this long
  std::optional<msg::Cause> latched = {};  ///< why the arm is held until a person resumes it; empty: it is not
  bool observed = false;                   ///< others move the arm from the start
};

/// Checks and interpolates commands, stops the arm when commands cease or the cell mode holds it, and explains why the
/// arm stands. After the device has stopped or failed, the arm is held until the supervisor holds it. Each period
/// consists of read(), any number of set_hold(), set_observed(), observe_lease() and command(), then write(). For one
/// thread.
class ArmControl {
 public:
  using Clock = device::Clock;

  /// The device must outlive it. The destructor stops and deactivates the device.
  ArmControl(const ArmControlSetup& setup, device::ArmDevice& device);

  /// Reads the device's state at `now`. Configures the device when possible, and activates it while nothing holds the
  /// arm.
  void read(Clock::time_point now);
  /// Why the cell mode holds the arm; empty: the arm may run. `for_device`: the hold is for the fault of the arm's
  /// device, so that this class need not hold the arm for it any more.
  void set_hold(std::optional<msg::Cause> hold, bool for_device = false);
  /// True: others move the arm from now on. A moving arm brakes first; commands have no effect any more. False: the
  /// planner commands the arm, from where it stands.
  void set_observed(bool observed);
  [[nodiscard]] bool observed() const { return observed_; }
  /// See CommandGate.
  void observe_lease(const ArmLease& lease) { gate_.observe_lease(lease); }
  void set_granted(std::optional<std::uint64_t> term) { gate_.set_granted(term); }
  /// Follows the command when it is acceptable and the arm may run. Stops the arm when it is too far from the
  /// set-point.
  Judgement command(const msg::ArmCommand& command, const std::optional<CommandOrigin>& origin = {});
  /// Sends the device its next set-point.
  void write();

  [[nodiscard]] msg::ArmMode mode() const;
  /// Why the arm brakes, stands or has failed; CAUSE_NONE while it follows commands.
  [[nodiscard]] msg::Cause cause() const;
  /// A measured joint moves.
  [[nodiscard]] bool moves() const;
  /// Measured joint positions and velocities; empty until the device has measured any.
  [[nodiscard]] const planner::JointState& measured() const { return session_.state().measured; }
  [[nodiscard]] Clock::time_point measured_at() const { return session_.measured_at(); }
  /// Share of the set-points' speed that the device executes, 0 to 1; 1 while it does not follow.
  [[nodiscard]] double speed_scaling() const { return session_.active() ? session_.state().speed_scaling : 1.0; }
  /// Lag of the measured state behind the set-points [s].
  [[nodiscard]] double tracking_delay() const { return session_.device().tracking_delay(); }
  /// Time since the last accepted command, or since the first period [s].
  [[nodiscard]] double command_age() const { return std::chrono::duration<double>(now_ - accepted_at_).count(); }
  /// The same at the measurement, as measured(); negative for a command that was accepted later [s].
  [[nodiscard]] double command_age_when_measured() const {
    return std::chrono::duration<double>(measured_at() - accepted_at_).count();
  }
  [[nodiscard]] const CommandGate& gate() const { return gate_; }

 private:
  void stop(const planner::JointState& from);
  void average_velocity(double dt);
  void leave_to_others();
  void interpolate();
  void approach(const planner::JointState& reference, double dt);
  [[nodiscard]] bool is_far(const planner::TimedSetPoint& set_point) const;
  [[nodiscard]] const planner::JointState& continues_from() const;

  ArmControlSetup setup_;
  DeviceSession session_;
  CommandGate gate_;
  planner::SetPointInterpolator interpolator_;
  Clock::time_point now_;           ///< of the last read()
  planner::JointVector mean_qd_;    ///< measured velocity, averaged over some periods [rad/s | m/s]
  Clock::time_point reference_at_;  ///< the instant of the interpolator's reference
  Clock::time_point accepted_at_;
  planner::JointState written_;        ///< the last set-point of the device
  bool commanded_ = false;             ///< a command has been accepted
  bool ran_ = false;                   ///< the arm has followed a command
  bool observed_ = false;              ///< others move the arm, once it has stopped
  std::optional<msg::Cause> hold_;     ///< of the cell mode
  std::optional<msg::Cause> refusal_;  ///< of the last command when it was refused
};

}  // namespace hecaton::services
