#pragma once
/// Runs a service's work once a period, on absolute deadlines of the monotonic clock, and measures it.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "services/bus/mailbox.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services {

struct LoopSummary {
  std::uint64_t ticks = 0;   ///< since the loop began
  double tick_p50_us = 0.0;  ///< duration of one period's work
  double tick_p99_us = 0.0;
  double tick_max_us = 0.0;
  double lateness_max_us = 0.0;  ///< of the timer
  std::uint64_t skipped = 0;     ///< periods skipped after stalls, since the loop began
};

/// Durations of a loop's ticks and the lateness of its timer over the last kWindow periods.
class LoopStatistics {
 public:
  static constexpr std::size_t kWindow = 512;

  void record_lateness(std::chrono::nanoseconds lateness, std::uint64_t skipped);
  void record_tick(std::chrono::nanoseconds spent);
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }  ///< since the loop began
  [[nodiscard]] double lateness_max_us() const;                 ///< over the last kWindow periods
  /// Over the last kWindow periods. Quantile p is the smallest value that at least a share p of them does not exceed.
  [[nodiscard]] LoopSummary summary() const;

 private:
  std::array<float, kWindow> tick_us_{};
  std::array<float, kWindow> lateness_us_{};
  std::uint64_t ticks_ = 0;
  std::uint64_t starts_ = 0;
  std::uint64_t skipped_ = 0;
};

/// A period of the cell file [s] as a duration; fractions of a nanosecond are cut off.
[[nodiscard]] inline std::chrono::nanoseconds nanoseconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
}

/// while (loop.next()) { one period's work; }
class PeriodicLoop {
 public:
  using Clock = std::chrono::steady_clock;

  /// The first period begins with the first next(). period > 0. `shutdown` must outlive the loop.
  PeriodicLoop(std::chrono::nanoseconds period, const ShutdownSignal& shutdown);

  /// Sleeps until the next deadline. Deadlines that passed during a stall are skipped, not caught up. Returns false
  /// when the process shall end.
  [[nodiscard]] bool next();
  /// As next(), but the period begins at once when something arrives in `mailbox` and `due()` then returns true. Later
  /// deadlines count from there.
  [[nodiscard]] bool next(bus::Mailbox& mailbox, const std::function<bool()>& due);

  [[nodiscard]] Clock::time_point now() const { return began_; }    ///< when the current period began
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }  ///< periods skipped right before the current one
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

struct NextDeadline {
  std::chrono::steady_clock::time_point at;
  std::uint64_t skipped = 0;  ///< deadlines between the former one and `at`
};
/// The deadline after `deadline` on the grid of `period`: the next one, or after a stall of a period or more the newest
/// that has passed at `now`.
[[nodiscard]] NextDeadline next_deadline(std::chrono::steady_clock::time_point deadline,
                                         std::chrono::steady_clock::time_point now, std::chrono::nanoseconds period);

}  // namespace hecaton::services
