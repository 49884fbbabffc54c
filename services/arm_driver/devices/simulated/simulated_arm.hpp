#pragma once
/// The simulated arm: joints with a position controller that never fails, in real time. Its position survives its
/// process, as a real arm's does.

#include <memory>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

[[nodiscard]] std::unique_ptr<ArmDevice> make_simulated_arm(const DeviceSetup& setup);

}  // namespace hecaton::device
