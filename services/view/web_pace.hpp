#pragma once
/// How fast the messages of one client are read. Those that come faster wait in its socket: none is lost, and the other
/// clients do not wait.

#include <algorithm>
#include <chrono>

namespace hecaton::services {

/// For one thread.
class WebPace {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kAtOnce = 512.0;     ///< messages; a page that opens asks for many files
  static constexpr double kPerSecond = 100.0;  ///< messages

  /// A message was read at `now`. Returns how long to wait before the next one is read; 0: not at all.
  [[nodiscard]] Clock::duration after_message(Clock::time_point now) {
    const double earned = std::chrono::duration<double>(now - at_).count() * kPerSecond;
    left_ = std::min(kAtOnce, left_ + std::max(0.0, earned)) - 1.0;
    at_ = now;
    const std::chrono::duration<double> wait(std::max(0.0, -left_) / kPerSecond);
    return std::chrono::duration_cast<Clock::duration>(wait);
  }

 private:
  double left_ = kAtOnce;
  Clock::time_point at_{};
};

}  // namespace hecaton::services
