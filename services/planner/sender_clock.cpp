#include "services/planner/sender_clock.hpp"

#include <algorithm>

namespace hecaton::services {

SenderClock::Clock::time_point SenderClock::sent(std::int64_t stamp_ns, Clock::time_point received) {
  // Longer differences are nonsense; so bounded, whatever stamp comes in, nothing below overflows.
  constexpr std::int64_t kLongest = std::int64_t{1} << 61;
  const Nanoseconds stamp(std::clamp(stamp_ns, -kLongest, kLongest));
  const Nanoseconds difference = received.time_since_epoch() - stamp;
  if (!least_ || received - window_began_ > kWindow) {
    previous_ = least_;
    least_ = difference;
    window_began_ = received;
  }
  least_ = std::min(*least_, difference);
  const Nanoseconds quickest = previous_ ? std::min(*least_, *previous_) : *least_;
  return received - (difference - quickest);
}

}  // namespace hecaton::services
