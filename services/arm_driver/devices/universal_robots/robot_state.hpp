#pragma once
/// The states of a Universal Robots controller, and what a person does about each. Pure.

#include <chrono>
#include <optional>
#include <string>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/arm_driver/devices/universal_robots/rtde_client.hpp"

namespace hecaton::device::universal_robots {

enum class RobotMode : std::int32_t {
  kNoController = -1,
  kDisconnected = 0,
  kConfirmSafety = 1,
  kBooting = 2,
  kPowerOff = 3,
  kPowerOn = 4,
  kIdle = 5,
  kBackdrive = 6,
  kRunning = 7,
  kUpdating = 8,
};

enum class SafetyMode : std::int32_t {
  kNormal = 1,
  kReduced = 2,
  kProtectiveStop = 3,
  kRecovery = 4,
  kSafeguardStop = 5,
  kSystemEmergencyStop = 6,
  kRobotEmergencyStop = 7,
  kViolation = 8,
  kFault = 9,
  kValidateJointId = 10,
  kUndefined = 11,
  // Of the e-Series.
  kAutomaticModeSafeguardStop = 12,
  kSystemThreePositionEnablingStop = 13,
  kPendantThreePositionEnablingStop = 14,
  kImmiEmergencyStop = 15,
  kImmiSafeguardStop = 16,
  kProfisafeWaitingForParameters = 17,
  kProfisafeAutomaticModeSafeguardStop = 18,
  kProfisafeSafeguardStop = 19,
  kProfisafeEmergencyStop = 20,
  kSafetyApiSafeguardStop = 22,
};

enum class RuntimeState : std::uint32_t {
  kStopping = 0,
  kStopped = 1,
  kPlaying = 2,
  kPausing = 3,
  kPaused = 4,
  kResuming = 5,
};

struct Condition {
  DeviceMode mode = DeviceMode::kReady;
  std::string text;
};

/// Whether robot and safety system allow motion of the arm; programs and remote control apart. `arm`: its name, for the
/// commands that the text names.
[[nodiscard]] Condition condition_of(const RobotData& data, const std::string& arm);

/// The second half of an order to power on: the robot's brakes, once it has booted. Pure; for one thread.
class BrakeRelease {
 public:
  /// A robot boots within this time. Later its surroundings may have changed.
  static constexpr std::chrono::seconds kLimit{30};

  /// The order begins.
  void begin(Clock::time_point now) { until_ = now + kLimit; }
  void cancel() { until_.reset(); }
  /// True: the brakes are due. After the limit, and in every safety mode but normal and reduced, the order is
  /// cancelled.
  [[nodiscard]] bool due(const RobotData& data, Clock::time_point now);

 private:
  std::optional<Clock::time_point> until_;  ///< empty: no such order is under way
};

}  // namespace hecaton::device::universal_robots
