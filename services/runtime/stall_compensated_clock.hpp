#pragma once
/// A clock that an observer uses to measure the silence of others. Standard library only: time is an argument.
///
/// The observer's own loop may stand still. Of such a stall the clock counts one loop period only, because the observer
/// cannot tell what others did meanwhile.

#include <algorithm>
#include <chrono>

namespace hecaton::services {

using Time = std::chrono::nanoseconds;  ///< since any fixed instant; never goes back

class StallCompensatedClock {
 public:
  /// After a stall of this a process has thrown away what waited in its sockets (services/bus/absence.hpp).
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
  /// The latest compensated instant that `at` can have been. `at` is not later than the last advance().
  [[nodiscard]] Time at(Time at) const { return std::min(compensated_before_ + (at - before_), compensated_); }
  [[nodiscard]] Time last_stall() const { return last_stall_; }  ///< duration of the latest; 0: none

 private:
  Time period_, limit_;
  Time now_, before_;  // the last two calls of advance()
  Time compensated_{0}, compensated_before_{0};
  Time last_stall_{0};
};

}  // namespace hecaton::services
