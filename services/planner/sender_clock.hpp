#pragma once
/// When a sender's samples were true, on the receiver's clock, without comparing clocks.

#include <chrono>
#include <cstdint>
#include <optional>

namespace hecaton::services {

/// Received minus stamped is the unknown offset of two clocks plus the time under way. Its minimum over the recent past
/// is the offset plus the quickest transit: what a sample has beyond that, it was delayed. The quickest transit itself
/// stays unknown and counts as nothing. One per sender and writer.
class SenderClock {
 public:
  using Clock = std::chrono::steady_clock;

  /// `stamp_ns` on the sender's steady clock. Never later than `received`.
  [[nodiscard]] Clock::time_point sent(std::int64_t stamp_ns, Clock::time_point received);

 private:
  using Nanoseconds = std::chrono::nanoseconds;

  /// The minimum is taken over this window and the one before, so that it follows drifting clocks.
  static constexpr std::chrono::seconds kWindow{10};

  std::optional<Nanoseconds> least_;     ///< received − stamped in this window
  std::optional<Nanoseconds> previous_;  ///< in the window before
  Clock::time_point window_began_{};
};

}  // namespace hecaton::services
