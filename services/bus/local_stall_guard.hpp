#pragma once
/// Isolates this process after it was itself stopped (SIGSTOP, a frozen container, a stalled machine). Private to
/// services/bus; standard library only.
///
/// Without isolation two things go wrong:
/// - The backlog in its sockets arrives as if it were new.
/// - After a long stall others have dropped its participant, while it has not dropped theirs. Fast DDS 2.9.1 does not
///   reliably heal such a one-sided loss: in 2 of 20 pauses two participants never exchanged their endpoints again
///   (docs/explanation/0005-process-recovery.md).
///
/// So after a stall the backlog is discarded, and reliable data are sent again. After a long stall the participant also
/// sends and receives nothing until the lease is over on both sides; then all discover each other again.

#include <algorithm>
#include <atomic>
#include <chrono>

#include "services/bus/mailbox.hpp"
#include "services/bus/rediscovery.hpp"

namespace hecaton::bus {

class LocalStallGuard {
 public:
  /// Period of update().
  static constexpr std::chrono::milliseconds kPeriod{50};
  /// A longer gap between two updates is a stall. Busy machines cause gaps of 126 ms every day.
  static constexpr std::chrono::milliseconds kStall{250};
  /// The receiving threads empty their sockets within this time.
  static constexpr std::chrono::milliseconds kBacklog{20};

  /// `lease`: of the participant and of its peers.
  LocalStallGuard(Clock::duration lease, Clock::time_point now) : lease_(lease), updated_(ticks(now)) {}

  /// For one thread. Returns true when it detects a long stall.
  bool update(Clock::time_point now) {
    const bool is_long = long_stall(now);
    if (now - updated() > kStall) back_ = ticks(now + (is_long ? quarantine(lease_) : Clock::duration(kBacklog)));
    updated_ = ticks(now);
    return is_long;
  }

  /// The process has not run for half a lease or more: its last announcement may be so old that others drop it.
  [[nodiscard]] bool long_stall(Clock::time_point now) const {
    return now - updated() > std::max(lease_ / 2, Clock::duration(kStall));
  }

  /// True while nothing may pass in either direction. Thread-safe; right from the first instant after a stall, also
  /// before update() has seen it.
  [[nodiscard]] bool isolated(Clock::time_point now) const { return now - updated() > kStall || ticks(now) < back_; }
  /// When a sample that is read now has arrived at the latest: `now`, or after a stall the last update before it, so
  /// that no sample counts as younger than it is.
  [[nodiscard]] Clock::time_point arrival(Clock::time_point now) const {
    const auto last = updated();
    return now - last > kStall ? last : now;
  }

 private:
  static Clock::rep ticks(Clock::time_point at) { return at.time_since_epoch().count(); }
  [[nodiscard]] Clock::time_point updated() const { return Clock::time_point(Clock::duration(updated_.load())); }

  Clock::duration lease_;
  std::atomic<Clock::rep> updated_;
  std::atomic<Clock::rep> back_ = 0;  ///< end of the isolation
};

}  // namespace hecaton::bus
