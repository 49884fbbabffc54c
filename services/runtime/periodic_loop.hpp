#pragma once
/// Runs a service's work once a period, on absolute deadlines of the monotonic clock.

#include <chrono>
#include <functional>

#include "services/bus/mailbox.hpp"
#include "services/runtime/loop_statistics.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services {

/// A period of the cell file [s] as a duration; fractions of a nanosecond are cut off.
[[nodiscard]] inline std::chrono::nanoseconds nanoseconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
}

/// while (loop.next()) { one period's work; }
class PeriodicLoop {
 public:
  using Clock = std::chrono::steady_clock;

  /// The first period begins with the first next(). period > 0.
  PeriodicLoop(std::chrono::nanoseconds period, const ShutdownSignal& shutdown);

  /// Sleeps until the next deadline. After a stall the deadlines that have passed are skipped, never caught up in a
  /// burst. False when the process is to end.
  [[nodiscard]] bool next();
  /// Likewise; but when something arrives in `mailbox` and `due()` then says so, the period begins at once, and the
  /// deadlines after it are counted from there.
  [[nodiscard]] bool next(bus::Mailbox& mailbox, const std::function<bool()>& due);

  /// When the running period began, and how long after its deadline.
  [[nodiscard]] Clock::time_point now() const { return began_; }
  /// Periods that passed unused right before the running one.
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }
  [[nodiscard]] const LoopStatistics& statistics() const { return statistics_; }
  [[nodiscard]] std::chrono::nanoseconds period() const { return period_; }

 private:
  void plan_next();
  bool begin();

  std::chrono::nanoseconds period_;
  const ShutdownSignal& shutdown_;
  Clock::time_point deadline_{};
  Clock::time_point began_{};
  bool running_ = false;
  std::uint64_t skipped_ = 0;
  LoopStatistics statistics_;
};

/// The deadline after `deadline` that is not yet over at `now`, on the grid of `period`; how many were skipped.
struct NextDeadline {
  std::chrono::steady_clock::time_point at;
  std::uint64_t skipped = 0;
};
[[nodiscard]] NextDeadline next_deadline(std::chrono::steady_clock::time_point deadline,
                                         std::chrono::steady_clock::time_point now, std::chrono::nanoseconds period);

}  // namespace hecaton::services
