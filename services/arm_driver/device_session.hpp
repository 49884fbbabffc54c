#pragma once
/// Brings the device of an arm into service, and keeps why it does not follow set-points. No network, no clock.

#include <chrono>
#include <optional>
#include <string>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {

struct DeviceSessionSetup {
  std::string arm;
  Eigen::Index joints = 0;
  double state_age_limit = 0.0;  ///< [s] an older measured state is a failure of the device
};

/// Why an arm that others move follows no commands.
[[nodiscard]] msg::Cause observed_cause(const std::string& arm);

/// Configures a device, activates it when the arm may move, and configures it again after a failure; until then it
/// reads on, so that the device can stop its arm. When a device stops following, the session latches: it does not
/// activate the device again before release() was called. For one thread.
class DeviceSession {
 public:
  using Clock = device::Clock;

  /// The device must outlive it. `latched`: why the arm is held from the start; empty: it is not.
  DeviceSession(DeviceSessionSetup setup, device::ArmDevice& device, std::optional<msg::Cause> latched);
  /// Stops and deactivates the device.
  ~DeviceSession();
  DeviceSession(const DeviceSession&) = delete;
  DeviceSession& operator=(const DeviceSession&) = delete;

  /// Reads the device's state at `now`. `may_move`: nothing holds the arm.
  void read(Clock::time_point now, bool may_move);
  /// Sends a set-point. Precondition: active().
  void write(const device::JointState& set_point, std::chrono::nanoseconds valid_for);
  /// Ends the latch: the supervisor holds the arm now, and its hold decides.
  void release() { latched_.reset(); }
  /// True: others move the arm. The session deactivates the device, and its stops hold nothing. Only a device that does
  /// not measure, or fails, is still a fault. False: as before; nothing is latched.
  void set_observed(bool observed);

  [[nodiscard]] bool observed() const { return observed_; }
  /// The device follows set-points.
  [[nodiscard]] bool active() const { return phase_ == Phase::kActive; }
  /// The last call failed, and the device has not worked since.
  [[nodiscard]] bool failed() const { return failure_.has_value(); }
  /// Why the device does not follow, and then why the session is latched; CAUSE_NONE: neither.
  [[nodiscard]] msg::Cause cause() const;
  /// Its last state. `measured` is empty until the device has measured any.
  [[nodiscard]] const device::DeviceState& state() const { return state_; }
  [[nodiscard]] Clock::time_point measured_at() const { return measured_at_; }
  [[nodiscard]] device::ArmDevice& device() { return device_; }
  [[nodiscard]] const device::ArmDevice& device() const { return device_; }

 private:
  enum class Phase {
    kUnconfigured,  ///< also after a failure
    kInactive,
    kActivating,  ///< activate() was called; the device is not ready yet
    kActive,
  };

  [[nodiscard]] bool configured();
  void go_on_stopping();
  void take(device::DeviceState state);
  [[nodiscard]] std::optional<std::string> unusable_state() const;
  void fail(const std::string& text);
  void follow();
  void leave();
  [[nodiscard]] msg::Cause cause_of_state() const;

  DeviceSessionSetup setup_;
  device::ArmDevice& device_;
  Phase phase_ = Phase::kUnconfigured;
  device::DeviceState state_;
  std::optional<std::string> failure_;
  std::optional<msg::Cause> latched_;
  Clock::time_point latched_at_;
  bool must_be_resumed_ = false;   ///< it has stopped following, and has not followed since
  bool stops_ = false;             ///< the device has failed after configure(), and stops its arm in read()
  bool observed_ = false;          ///< others move the arm
  Clock::time_point now_;          ///< of the last read()
  Clock::time_point measured_at_;  ///< of the measured state
  Clock::time_point retry_at_;     ///< when a failed device is configured again
};

}  // namespace hecaton::services
