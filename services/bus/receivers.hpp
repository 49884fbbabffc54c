#pragma once
/// Which receiving threads are at work on a datagram, and since when. Private to services/bus.
///
/// Fast DDS 2.9.1 can lock itself up: a receiving thread that removes a writer holds the lock of discovery and waits
/// for the thread of timers, which waits for that lock to judge a lease. Every other receiving thread then waits behind
/// it for good, while the process's own loops go on and look healthy to its agent. Only starting anew helps.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

class Receivers {
 public:
  /// A datagram takes microseconds; a thread that has not come back for so long never will.
  static constexpr std::chrono::seconds kHung{20};

  /// A thread begins with a datagram. → the place that it gives back to leave().
  std::size_t enter(Clock::time_point now) {
    for (std::size_t i = 0; i < began_.size(); ++i) {
      Clock::rep free = 0;
      if (began_[i].compare_exchange_strong(free, now.time_since_epoch().count())) return i;
    }
    return began_.size();  // more threads than that are not watched
  }
  void leave(std::size_t place) {
    if (place < began_.size()) began_[place] = 0;
  }

  /// How long the slowest has been at work; time before `since` does not count, because the process did not run.
  [[nodiscard]] Clock::duration longest(Clock::time_point now, Clock::time_point since) const {
    auto longest = Clock::duration::zero();
    for (const auto& began : began_) {
      const Clock::rep at = began;
      if (at != 0) longest = std::max(longest, now - std::max(since, Clock::time_point(Clock::duration(at))));
    }
    return longest;
  }

 private:
  std::array<std::atomic<Clock::rep>, 32> began_{};
};

}  // namespace hecaton::bus
