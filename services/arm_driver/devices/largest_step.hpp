#pragma once
/// A limit for steps of set-points, for devices whose controllers follow a jump as fast as they can.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

/// Why the step from one set-point to the next is a jump: a sentence with the joint; empty: it is none. `velocity`:
/// limits of the joints. `since`: time from `before` to `after`.
[[nodiscard]] inline std::optional<std::string> jump(const JointVector& velocity, const JointVector& before,
                                                     const JointVector& after, Clock::duration since) {
  // Set-points may move this many times faster than the velocity limits: the driver catches up with 1.5 times.
  constexpr double kFastestSetPoint = 2.0;
  constexpr double kSmallStep = 1e-3;    // no jump [rad | m]
  constexpr double kLongestPause = 0.1;  // beyond it a pause between set-points allows no larger step [s]
  const double pause = std::min(kLongestPause, std::chrono::duration<double>(since).count());
  for (Eigen::Index joint = 0; joint < after.size(); ++joint) {
    const double step = std::abs(after[joint] - before[joint]);
    const double most = kFastestSetPoint * velocity[joint] * pause + kSmallStep;
    if (step <= most) continue;
    char text[128];
    std::snprintf(text, sizeof text, "the set-point of joint %d jumps by %.4f (limit %.4f): it was not sent",
                  static_cast<int>(joint) + 1, step, most);
    return text;
  }
  return std::nullopt;
}

}  // namespace hecaton::device
