#pragma once
/// A clock for measuring the silence of other processes. Standard library only: time is an argument.

#include <algorithm>
#include <chrono>

namespace hecaton::services {

using Time = std::chrono::nanoseconds;  ///< since any fixed instant; never goes back

/// After a stall of the observer's own loop it advances by one loop period only, because the observer cannot tell what
/// other processes did meanwhile.
class StallCompensatedClock {
 public:
  /// After a stall of this length the bus discards the backlog of its sockets (services/bus/local_stall_guard.hpp).
  static constexpr Time kLongStall = std::chrono::milliseconds(250);

  /// An interval between two calls of advance() above `limit` is a stall, of which only `period` counts.
  StallCompensatedClock(Time period, Time limit, Time now) : period_(period), limit_(limit), now_(now), before_(now) {}

  /// Call it once in each turn of the loop. Returns true after a stall.
  bool advance(Time now) {
    before_ = now_;
    compensated_before_ = compensated_;
    now_ = std::max(now, now_);
    const Time interval = now_ - before_;
    const bool stalled = interval > limit_;
    compensated_ += stalled ? period_ : interval;
    if (stalled) last_stall_ = interval;
    return stalled;
  }

  [[nodiscard]] Time now() const { return compensated_; }
  /// The latest compensated time that corresponds to `at`, which is not later than the last advance().
  [[nodiscard]] Time at(Time at) const { return std::min(compensated_before_ + (at - before_), compensated_); }
  [[nodiscard]] Time last_stall() const { return last_stall_; }  ///< duration of the latest stall; 0: none

 private:
  Time period_, limit_;
  Time now_, before_;  // the last two calls of advance()
  Time compensated_{0}, compensated_before_{0};
  Time last_stall_{0};
};

}  // namespace hecaton::services
