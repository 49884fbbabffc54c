#pragma once
/// When messages with stamps of another clock were sent. Standard library only.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

namespace hecaton::services {

/// Estimates when samples of one writer were sent, on the clock of the receiver. Reception time minus stamp is the
/// offset of the two clocks plus the latency. Its minimum over the last one to two windows is the offset plus the
/// smallest latency; the excess over the minimum is the delay of a sample. The smallest latency itself is unknown and
/// counts as 0.
class SenderClock {
 public:
  using Clock = std::chrono::steady_clock;

  explicit SenderClock(std::chrono::seconds window = std::chrono::seconds(10)) : window_(window) {}

  /// The time at which the sample was sent; never later than `received`. `stamp_ns`: on the sender's steady clock.
  [[nodiscard]] Clock::time_point sent(std::int64_t stamp_ns, Clock::time_point received) {
    // Bounds invalid stamps, so that no difference overflows.
    constexpr std::int64_t kLongest = std::int64_t{1} << 61;
    const Nanoseconds stamp(std::clamp(stamp_ns, -kLongest, kLongest));
    const Nanoseconds difference = received.time_since_epoch() - stamp;
    if (!least_ || received - window_began_ > window_) {
      previous_ = std::exchange(least_, difference);
      window_began_ = received;
    }
    least_ = std::min(*least_, difference);
    return received - (difference - std::min(*least_, previous_.value_or(*least_)));
  }

 private:
  using Nanoseconds = std::chrono::nanoseconds;

  std::chrono::seconds window_;          ///< the minimum is over this window and the one before, as clocks drift
  std::optional<Nanoseconds> least_;     ///< received − stamped in this window
  std::optional<Nanoseconds> previous_;  ///< in the window before
  Clock::time_point window_began_{};
};

}  // namespace hecaton::services
