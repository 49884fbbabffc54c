#include "services/arm_driver/devices/universal_robots/robot_state.hpp"

namespace hecaton::device::universal_robots {
namespace {

constexpr const char* kMachine = "the injection moulding machine (IMMI)";
constexpr const char* kSafetyPlc = "the safety PLC (PROFIsafe)";

/// `origin`: words such as "by the safety PLC"; may be empty.
Condition safeguard_stop(const std::string& origin, const std::string& resume) {
  return {DeviceMode::kSafeguardStop, "safeguard stop" + (origin.empty() ? "" : " " + origin) +
                                          ": clear the safeguarded space and reset the safeguard, then call " + resume};
}

/// Every safety mode but normal and reduced forbids motion, also those of later controllers.
Condition condition_of_safety(SafetyMode mode, const std::string& arm) {
  const std::string resume = "'hecaton resume " + arm + "'";
  const std::string on = "'hecaton device " + arm + " on'";
  switch (mode) {
    case SafetyMode::kNormal:
    case SafetyMode::kReduced:
      return {};
    case SafetyMode::kProtectiveStop:
      return {DeviceMode::kProtectiveStop, "protective stop: look at the arm, then call 'hecaton device " + arm +
                                               " unlock', 5 s after the stop or later, and " + resume};
    case SafetyMode::kSystemEmergencyStop:
    case SafetyMode::kRobotEmergencyStop:
      return {DeviceMode::kEmergencyStop,
              "emergency stop: release the emergency stop button, then call " + on + " and " + resume};
    case SafetyMode::kImmiEmergencyStop:
    case SafetyMode::kProfisafeEmergencyStop:
      return {DeviceMode::kEmergencyStop,
              "emergency stop by " + std::string(mode == SafetyMode::kImmiEmergencyStop ? kMachine : kSafetyPlc) +
                  ": end the emergency stop there, then call " + on + " and " + resume};
    case SafetyMode::kRecovery:
      return {DeviceMode::kNotReady,
              "recovery mode: move the arm into its safety limits at the teach pendant, then call " + resume};
    case SafetyMode::kViolation:
    case SafetyMode::kFault:
      return {DeviceMode::kNotReady,
              "safety violation or fault: read the log at the teach pendant and restart the safety system there, then "
              "call " +
                  on + " and " + resume};
    case SafetyMode::kValidateJointId:
    case SafetyMode::kUndefined:
      return {DeviceMode::kNotReady, "the safety system is not ready: act at the teach pendant, then call " + resume};
    case SafetyMode::kSystemThreePositionEnablingStop:
    case SafetyMode::kPendantThreePositionEnablingStop:
      return {
          DeviceMode::kSafeguardStop,
          "an enabling device " +
              std::string(mode == SafetyMode::kPendantThreePositionEnablingStop ? "of the teach pendant " : "") +
              "stops the robot: switch the robot to automatic mode, or hold the device in its middle position, then "
              "call " +
              resume};
    case SafetyMode::kProfisafeWaitingForParameters:
      return {DeviceMode::kNotReady, "the safety system waits for parameters of " + std::string(kSafetyPlc) +
                                         ": start it and check its connection, then call " + resume};
    case SafetyMode::kImmiSafeguardStop:
      return safeguard_stop(std::string("by ") + kMachine, resume);
    case SafetyMode::kProfisafeAutomaticModeSafeguardStop:
    case SafetyMode::kProfisafeSafeguardStop:
      return safeguard_stop(std::string("by ") + kSafetyPlc, resume);
    case SafetyMode::kAutomaticModeSafeguardStop:
      return safeguard_stop("of the automatic mode", resume);
    case SafetyMode::kSafetyApiSafeguardStop:
      return safeguard_stop("by a program of the safety interface", resume);
    case SafetyMode::kSafeguardStop:
      return safeguard_stop("", resume);
  }
  return {DeviceMode::kSafeguardStop, "the safety system stops the robot (safety mode " +
                                          std::to_string(static_cast<std::int32_t>(mode)) +
                                          "): read the reason at the teach pendant, then call " + resume};
}

Condition condition_of_robot(RobotMode mode, const std::string& arm) {
  const std::string on_and_resume = "call 'hecaton device " + arm + " on' and 'hecaton resume " + arm + "'";
  switch (mode) {
    case RobotMode::kRunning:
      return {};
    case RobotMode::kPowerOff:
      return {DeviceMode::kNotReady, "the robot is off: " + on_and_resume};
    case RobotMode::kIdle:
      return {DeviceMode::kNotReady, "the brakes are on: " + on_and_resume};
    case RobotMode::kPowerOn:
    case RobotMode::kBooting:
      return {DeviceMode::kNotReady, "the robot boots: wait, then " + on_and_resume};
    case RobotMode::kConfirmSafety:
      return {DeviceMode::kNotReady, "the safety configuration waits for its confirmation at the teach pendant"};
    case RobotMode::kBackdrive:
      return {DeviceMode::kNotReady, "the robot is in backdrive mode: end it at the teach pendant"};
    case RobotMode::kUpdating:
      return {DeviceMode::kNotReady, "the robot updates its firmware: wait"};
    case RobotMode::kNoController:
    case RobotMode::kDisconnected:
      break;
  }
  return {DeviceMode::kNotReady, "the controller has no connection to its arm: look at the teach pendant"};
}

}  // namespace

Condition condition_of(const RobotData& data, const std::string& arm) {
  Condition safety = condition_of_safety(static_cast<SafetyMode>(data.safety_mode), arm);
  if (safety.mode != DeviceMode::kReady) return safety;
  return condition_of_robot(static_cast<RobotMode>(data.robot_mode), arm);
}

bool BrakeRelease::due(const RobotData& data, Clock::time_point now) {
  const auto safety = static_cast<SafetyMode>(data.safety_mode);
  const bool safe = safety == SafetyMode::kNormal || safety == SafetyMode::kReduced;
  if (until_ && (!safe || now > *until_)) cancel();
  return until_ && static_cast<RobotMode>(data.robot_mode) == RobotMode::kIdle;
}

}  // namespace hecaton::device::universal_robots
