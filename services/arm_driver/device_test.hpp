#pragma once
/// The conformance test of a device: moves its arm a little through the driver's own code, and measures whether the
/// device keeps the contract of devices/arm_device.hpp. No network, no clock.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "services/arm_driver/arm_control.hpp"

namespace hecaton::services {

/// The periods of a driver's loop, in real or virtual time.
class DriverPeriods {
 public:
  using Clock = device::Clock;

  virtual ~DriverPeriods() = default;
  /// Waits for the next period. Returns the instant of its begin.
  [[nodiscard]] virtual Clock::time_point next() = 0;
  /// By how much this machine exceeded the last wait; zero when there was nothing to wait for.
  [[nodiscard]] virtual Clock::duration late() const = 0;
  [[nodiscard]] virtual Clock::time_point now() const = 0;
  /// True: a person ends the test.
  [[nodiscard]] virtual bool ended() const = 0;
};

struct DeviceTestSetup {
  ArmControlSetup control;
  double control_period = 0.01;                         ///< of the commands [s]
  double distance = 0.05;                               ///< that each joint moves [rad | m]
  double duration = 2.0;                                ///< of the motion of each joint, at least [s]
  std::function<void(std::string_view)> progress = {};  ///< what the test does or waits for; may be empty
};

enum class CheckResult { kOk, kFailed, kNotTested };

/// One property of the device.
struct DeviceCheck {
  std::string name;   ///< a word: "state_age"
  std::string title;  ///< a phrase: "the measured state is fresh"
  std::string unit;   ///< of both values: "s", or "rad" for rad and m
  double measured = 0.0;
  double limit = 0.0;  ///< largest value that passes
  CheckResult result = CheckResult::kNotTested;
  std::string details = {};  ///< a phrase; may be empty
};

struct DeviceTestReport {
  std::vector<DeviceCheck> checks;  ///< always all of them, in the same order
  double longest_gap = 0.0;         ///< between the begins of two periods [s]

  [[nodiscard]] bool passed() const;
  /// Number of checks with a result.
  [[nodiscard]] int tested() const;
};

/// Tests the device. The arm moves: each joint by setup.distance and back, alone and all together, without a planner
/// that avoids contacts. A check of a motion that fails ends all motions. At the end, also at an early one, the device
/// is stopped and deactivated. Errors of tracking that a stall of this machine causes do not count. Takes half a minute
/// with the defaults and six joints.
[[nodiscard]] DeviceTestReport test_device(const DeviceTestSetup& setup, device::ArmDevice& device,
                                           DriverPeriods& periods);

}  // namespace hecaton::services
