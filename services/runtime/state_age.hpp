#pragma once
/// How old a measurement is that a driver repeats, because its device measures no longer.

#include <algorithm>
#include <chrono>

#include <idl/arm.h>

#include "services/runtime/sender_clock.hpp"

namespace hecaton::services {

/// The least age of the measurement in `state` when its driver sent it. While the device fails, drivers go on to accept
/// commands: the newest one came after the measurement. So a reader that starts now knows that the state is old. 0 to
/// 10⁶ s; 0 also while the device works.
[[nodiscard]] inline std::chrono::nanoseconds least_age(const msg::ArmState& state) {
  if (state.mode() != msg::ArmMode::ARM_FAILED || !(state.command_age() < 0.0)) return {};
  const std::chrono::duration<double> accepted_later(std::min(-state.command_age(), 1e6));
  return std::chrono::duration_cast<std::chrono::nanoseconds>(accepted_later);
}

/// When the measurement in `state` was made, on the clock of `received`, which is the arrival of the message. `driver`:
/// of its writer.
[[nodiscard]] inline SenderClock::Clock::time_point measured_at(const msg::ArmState& state,
                                                                SenderClock::Clock::time_point received,
                                                                SenderClock& driver) {
  return std::min(driver.sent(state.stamp_ns(), received), received - least_age(state));
}

}  // namespace hecaton::services
