#pragma once
/// Whether this process was itself stopped (SIGSTOP, a frozen container, a stalled machine), and how long it then stays
/// away from the network. Private to services/bus.
///
/// Two things would go wrong if it just went on:
/// - What waited in its sockets would arrive as if it were new.
/// - Others may have dropped its participant when the lease was over, while it has not dropped theirs. Fast DDS 2.9.1
///   does not heal such a one-sided loss reliably: in 2 of 20 pauses two participants never
///   exchanged their endpoints again (docs/design/0005-return.md).
///
/// So after a stall the backlog is thrown away (what is reliable is sent again), and after a long one the participant
/// stays silent and deaf until the lease is over on both sides. Then all meet anew, with endpoints, histories and
/// sequence numbers as they were.

#include <algorithm>
#include <atomic>
#include <chrono>

#include "services/bus/mailbox.hpp"
#include "services/bus/reunion.hpp"

namespace hecaton::bus {

class Absence {
 public:
  /// look() is called this often while the process runs.
  static constexpr std::chrono::milliseconds kLook{50};
  /// A process that did not look for so long was stopped. Stalls of 126 ms are everyday life on a busy machine.
  static constexpr std::chrono::milliseconds kStall{250};
  /// The receiving threads empty their sockets within this.
  static constexpr std::chrono::milliseconds kBacklog{20};

  /// `lease`: of the participant and of its peers.
  Absence(Clock::duration lease, Clock::time_point now) : lease_(lease), looked_(ticks(now)) {}

  /// True: a long absence begins. Of one thread.
  bool look(Clock::time_point now) {
    const bool is_long = overslept(now);
    if (now - looked() > kStall) back_ = ticks(now + (is_long ? quarantine(lease_) : Clock::duration(kBacklog)));
    looked_ = ticks(now);
    return is_long;
  }

  /// Others may have dropped us: what they heard last may be an announcement from well before the stall.
  [[nodiscard]] bool overslept(Clock::time_point now) const {
    return now - looked() > std::max(lease_ / 2, Clock::duration(kStall));
  }

  /// Nothing may pass in either direction. Right from the first instant after a stall, whichever thread asks first.
  [[nodiscard]] bool away(Clock::time_point now) const { return now - looked() > kStall || ticks(now) < back_; }
  /// `now`, or when the process is last known to have run if it was stopped since: no sample is younger than it looks.
  [[nodiscard]] Clock::time_point arrival(Clock::time_point now) const {
    const auto last = looked();
    return now - last > kStall ? last : now;
  }

 private:
  static Clock::rep ticks(Clock::time_point at) { return at.time_since_epoch().count(); }
  [[nodiscard]] Clock::time_point looked() const { return Clock::time_point(Clock::duration(looked_.load())); }

  Clock::duration lease_;
  std::atomic<Clock::rep> looked_;
  std::atomic<Clock::rep> back_ = 0;
};

}  // namespace hecaton::bus
