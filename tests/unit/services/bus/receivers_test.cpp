#include "services/bus/receivers.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

constexpr Clock::time_point kBegin{1h};

TEST(Receivers, NobodyAtWorkIsNobodyHung) {
  Receivers receivers;
  receivers.leave(receivers.enter(kBegin));
  EXPECT_EQ(receivers.longest(kBegin + 1h, kBegin), 0s);
}

TEST(Receivers, TheSlowestCounts) {
  Receivers receivers;
  const auto first = receivers.enter(kBegin);
  const auto second = receivers.enter(kBegin + 3s);
  EXPECT_EQ(receivers.longest(kBegin + 10s, kBegin), 10s);
  receivers.leave(first);
  EXPECT_EQ(receivers.longest(kBegin + 10s, kBegin), 7s);
  receivers.leave(second);
  EXPECT_EQ(receivers.longest(kBegin + 10s, kBegin), 0s);
}

TEST(Receivers, TimeInWhichTheProcessWasStoppedDoesNotCount) {
  Receivers receivers;
  receivers.enter(kBegin);
  EXPECT_EQ(receivers.longest(kBegin + 60s, kBegin + 59s), 1s);
}

TEST(Receivers, MoreThreadsThanPlacesAreNotWatched) {
  Receivers receivers;
  for (int i = 0; i < 40; ++i) receivers.leave(receivers.enter(kBegin));
  std::size_t last = 0;
  for (int i = 0; i < 40; ++i) last = receivers.enter(kBegin);
  receivers.leave(last);
  EXPECT_EQ(receivers.longest(kBegin + 1s, kBegin), 1s);
}

}  // namespace
}  // namespace hecaton::bus
