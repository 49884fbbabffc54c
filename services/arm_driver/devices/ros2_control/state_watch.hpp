#pragma once
/// Finds out that a controller has ceased to publish its state: it is inactive, also if only for a moment. No network.

#include <algorithm>
#include <optional>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::ros2_control {

/// For one thread.
class StateWatch {
 public:
  /// A controller whose rate is not known yet, and every other one, publishes at least this often.
  static constexpr std::chrono::seconds kLongest{1};
  /// A busy machine may delay each controller for this time.
  static constexpr std::chrono::milliseconds kShortest{200};

  /// `late`: a state may be late for this time, when that is longer than the times above.
  explicit StateWatch(Clock::duration late)
      : shortest_(std::max<Clock::duration>(kShortest, late)), longest_(std::max<Clock::duration>(kLongest, late)) {}

  void add(Clock::time_point received) {
    if (received_ && received - *received_ <= limit()) {
      // The mean of many gaps: single ones are late or early.
      const Clock::duration gap = received - *received_;
      period_ = gaps_ == 0 ? gap : period_ + (gap - period_) / kMean;
      gaps_ = std::min(gaps_ + 1, kEnough);
    }
    received_ = received;
  }

  /// No state has come for some of the controller's periods, or none at all.
  [[nodiscard]] bool is_silent(Clock::time_point now) const { return !received_ || now - *received_ > limit(); }
  /// The longest silence of an active controller.
  [[nodiscard]] Clock::duration limit() const {
    return gaps_ < kEnough ? longest_ : std::clamp(kMissing * period_, shortest_, longest_);
  }

 private:
  static constexpr int kMissing = 5;
  static constexpr int kMean = 10;
  static constexpr int kEnough = 10;  // gaps after which the rate is known

  Clock::duration shortest_, longest_;
  Clock::duration period_{0};
  int gaps_ = 0;
  std::optional<Clock::time_point> received_;  ///< the newest state
};

}  // namespace hecaton::device::ros2_control
