#pragma once
/// A device of one's own: an arm over a serial line that speaks lines of text.
///
///     arm → driver   S q₁ … qₙ q̇₁ … q̇ₙ      measured state [rad], [rad/s]; a few milliseconds apart
///                    F what has failed       instead of a state, as long as it has failed
///     driver → arm   M q₁ … qₙ q̇₁ … q̇ₙ ms   be there after one period; stop when nothing follows for so many ms
///                    H                       stop

#include <memory>

#include "services/arm_driver/devices/arm_device.hpp"

/// Keys in the cell file: `port`, the path of the serial line.
[[nodiscard]] std::unique_ptr<hecaton::device::ArmDevice> make_serial_arm(const hecaton::device::DeviceSetup& setup);
