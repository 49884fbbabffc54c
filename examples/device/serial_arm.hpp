#pragma once
/// Example of a device: an arm on a serial line with a text protocol.
///
///     arm → driver   S q₁ … qₙ q̇₁ … q̇ₙ      measured state [rad], [rad/s], every few milliseconds
///                    F description           instead of a state while the arm has failed
///     driver → arm   M q₁ … qₙ q̇₁ … q̇ₙ ms   set-point for the end of the period; stop without a successor within ms
///                    H                       stop

#include <memory>

#include "services/arm_driver/devices/arm_device.hpp"

/// Keys in the cell file: `port`, the path of the serial line.
[[nodiscard]] std::unique_ptr<hecaton::device::ArmDevice> make_serial_arm(const hecaton::device::DeviceSetup& setup);
