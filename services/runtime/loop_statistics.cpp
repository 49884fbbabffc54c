#include "services/runtime/loop_statistics.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::services {
namespace {

float microseconds(std::chrono::nanoseconds duration) {
  return static_cast<float>(static_cast<double>(duration.count()) / 1e3);
}

}  // namespace

void LoopStatistics::record_lateness(std::chrono::nanoseconds lateness, std::uint64_t skipped) {
  lateness_us_[starts_++ % kWindow] = microseconds(lateness);
  skipped_ += skipped;
}

void LoopStatistics::record_tick(std::chrono::nanoseconds spent) {
  tick_us_[ticks_++ % kWindow] = microseconds(spent);
}

double LoopStatistics::lateness_max_us() const {
  const auto count = static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(starts_, kWindow));
  return count == 0 ? 0.0 : *std::max_element(lateness_us_.begin(), lateness_us_.begin() + count);
}

LoopSummary LoopStatistics::summary() const {
  LoopSummary result;
  result.ticks = ticks_;
  result.skipped = skipped_;
  result.lateness_max_us = lateness_max_us();
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(ticks_, kWindow));
  if (count == 0) return result;
  std::array<float, kWindow> sorted = tick_us_;
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
  const auto quantile = [&](double p) {
    const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(count)));
    return static_cast<double>(sorted[std::max<std::size_t>(rank, 1) - 1]);
  };
  result.tick_p50_us = quantile(0.50);
  result.tick_p99_us = quantile(0.99);
  result.tick_max_us = sorted[count - 1];
  return result;
}

}  // namespace hecaton::services
