#include "services/runtime/periodic_loop.hpp"

#include <algorithm>
#include <ctime>

#include <sys/prctl.h>

namespace hecaton::services {
namespace {

/// Wakes early when a signal arrives in this thread; the caller looks at the clock again.
void sleep_until(std::chrono::steady_clock::time_point at) {
  const auto since_boot = at.time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since_boot);
  timespec time{};
  time.tv_sec = static_cast<time_t>(seconds.count());
  time.tv_nsec = static_cast<long>(std::chrono::nanoseconds(since_boot - seconds).count());
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);
}

}  // namespace

NextDeadline next_deadline(std::chrono::steady_clock::time_point deadline, std::chrono::steady_clock::time_point now,
                           std::chrono::nanoseconds period) {
  deadline += period;
  if (now < deadline + period) return {deadline, 0};  // on time, or late by less than a period: keep the grid
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
    prctl(PR_SET_TIMERSLACK, 1UL);  // the kernel's default would add up to 50 µs to every period
    deadline_ = finished;
    running_ = true;
  }
}

bool PeriodicLoop::begin() {
  began_ = Clock::now();
  // A stall of the machine while asleep shows here, one in the work in the tick's own time.
  statistics_.record_lateness(std::max(began_ - deadline_, Clock::duration::zero()), skipped_);
  return !shutdown_.requested();
}

}  // namespace hecaton::services
