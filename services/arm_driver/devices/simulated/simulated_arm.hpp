#pragma once
/// The simulated arm: joints with a position controller, in real time, perfect or not. Its position survives its
/// process, as a real arm's does.

#include <memory>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

inline constexpr std::string_view kSimulatedPorts =
    "digital_input, digital_output, analog_input or analog_output, with a number behind it or without; "
    "protective_stop, "
    "emergency_stop, connection_lost or speed_scaling";
/// See DeviceType::signal.
[[nodiscard]] std::optional<SignalKind> simulated_signal(std::string_view port);
[[nodiscard]] std::unique_ptr<ArmDevice> make_simulated_arm(const DeviceSetup& setup);

}  // namespace hecaton::device
