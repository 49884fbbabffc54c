#pragma once
/// How long a loop's ticks took and how late its timer was, over the last kWindow periods.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace hecaton::services {

struct LoopSummary {
  std::uint64_t ticks = 0;   ///< since the loop began
  double tick_p50_us = 0.0;  ///< of the work of one period
  double tick_p99_us = 0.0;
  double tick_max_us = 0.0;
  double lateness_max_us = 0.0;  ///< of the timer
  std::uint64_t skipped = 0;     ///< periods that a stall swallowed, since the loop began
};

class LoopStatistics {
 public:
  static constexpr std::size_t kWindow = 512;

  void record_lateness(std::chrono::nanoseconds lateness, std::uint64_t skipped);
  void record_tick(std::chrono::nanoseconds spent);
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }  ///< since the loop began
  [[nodiscard]] double lateness_max_us() const;                 ///< over the last kWindow periods
  /// Over the last kWindow periods. Quantile p is the smallest value that at least p of them do not exceed.
  [[nodiscard]] LoopSummary summary() const;

 private:
  std::array<float, kWindow> tick_us_{};
  std::array<float, kWindow> lateness_us_{};
  std::uint64_t ticks_ = 0;
  std::uint64_t starts_ = 0;
  std::uint64_t skipped_ = 0;
};

}  // namespace hecaton::services
