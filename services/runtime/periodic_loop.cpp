#include "services/runtime/periodic_loop.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>

#include <sys/prctl.h>

namespace hecaton::services {
namespace {

/// May return early when this thread receives a signal.
void sleep_until(std::chrono::steady_clock::time_point at) {
  const auto since_boot = at.time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since_boot);
  timespec time{};
  time.tv_sec = static_cast<time_t>(seconds.count());
  time.tv_nsec = static_cast<long>(std::chrono::nanoseconds(since_boot - seconds).count());
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);
}

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

NextDeadline next_deadline(std::chrono::steady_clock::time_point deadline, std::chrono::steady_clock::time_point now,
                           std::chrono::nanoseconds period) {
  deadline += period;
  if (now < deadline + period) return {deadline, 0};  // late by less than a period: keep the grid
  const auto skipped = (now - deadline) / period;
  return {deadline + skipped * period, static_cast<std::uint64_t>(skipped)};
}

PeriodicLoop::PeriodicLoop(std::chrono::nanoseconds period, const ShutdownSignal& shutdown)
    : period_(period), shutdown_(shutdown) {}

bool PeriodicLoop::next() {
  plan_next();
  while (!shutdown_.requested() && Clock::now() < deadline_) sleep_until(deadline_);
  return begin();
}

bool PeriodicLoop::next(bus::Mailbox& mailbox, const std::function<bool()>& due) {
  plan_next();
  while (!shutdown_.requested() && Clock::now() < deadline_) {
    if (mailbox.wait(deadline_ - Clock::now()) && due()) deadline_ = std::min(deadline_, Clock::now());
  }
  return begin();
}

void PeriodicLoop::plan_next() {
  const auto finished = Clock::now();
  skipped_ = 0;
  if (running_) {
    statistics_.record_tick(finished - began_);
    const NextDeadline next = next_deadline(deadline_, finished, period_);
    deadline_ = next.at;
    skipped_ = next.skipped;
  } else {
    prctl(PR_SET_TIMERSLACK, 1UL);  // the default adds up to 50 µs to every period
    deadline_ = finished;
    running_ = true;
  }
}

bool PeriodicLoop::begin() {
  began_ = Clock::now();
  // A stall during the sleep counts as lateness, one during the work as a long tick.
  statistics_.record_lateness(std::max(began_ - deadline_, Clock::duration::zero()), skipped_);
  return !shutdown_.requested();
}

}  // namespace hecaton::services
