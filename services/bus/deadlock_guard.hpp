#pragma once
/// Bounds the time that this process can lose to a deadlock inside Fast DDS. Private to services/bus; standard library
/// and system calls only.
///
/// In Fast DDS 2.9.1 a thread that removes an endpoint holds the lock of discovery and waits for the thread of timers,
/// which may wait for the same lock to check the lease of a peer that has just died. All receiving threads then wait
/// for ever, while the process's own loops run on and look healthy to the agent. Only a restart of the process helps.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// Measures for how long receiving threads have worked on their datagrams. Thread-safe.
class ReceiverWatchdog {
 public:
  /// A datagram takes microseconds: a thread that has worked for this long never returns.
  static constexpr std::chrono::seconds kLimit{20};

  /// A thread begins with a datagram. Returns the slot to give back to leave().
  std::size_t enter(Clock::time_point now) {
    for (std::size_t i = 0; i < began_.size(); ++i) {
      Clock::rep free = 0;
      if (began_[i].compare_exchange_strong(free, now.time_since_epoch().count())) return i;
    }
    return began_.size();  // further threads are not watched
  }
  void leave(std::size_t slot) {
    if (slot < began_.size()) began_[slot] = 0;
  }

  /// For how long the slowest thread has worked. Time before `since` does not count, because the process did not run.
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

/// No removal from Fast DDS takes this long on any machine.
constexpr std::chrono::seconds kRemovalLimit{10};

/// Runs `work` on a thread of its own and waits for its end, at most for `limit`. Returns false when it has not ended:
/// the thread and all that it uses must then stay. The process still ends with its exit code, but without running
/// destructors of global objects.
[[nodiscard]] bool finishes_within(Clock::duration limit, std::function<void()> work);

}  // namespace hecaton::bus
