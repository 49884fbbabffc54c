#pragma once
/// Durations in the messages of devices.

#include <chrono>
#include <string>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

/// "250 ms".
[[nodiscard]] inline std::string milliseconds(Clock::duration time) {
  return std::to_string(std::chrono::round<std::chrono::milliseconds>(time).count()) + " ms";
}

}  // namespace hecaton::device
