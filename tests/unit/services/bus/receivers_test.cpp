#include "services/bus/receivers.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

constexpr Clock::time_point kFirstInstant{1h};

TEST(Receivers, NobodyAtWorkIsNobodyHung) {
  Receivers receivers;
  receivers.leave(receivers.enter(kFirstInstant));
  EXPECT_EQ(receivers.longest(kFirstInstant + 1h, kFirstInstant), 0s);
}

TEST(Receivers, TheSlowestCounts) {
  Receivers receivers;
  const auto first = receivers.enter(kFirstInstant);
  const auto second = receivers.enter(kFirstInstant + 3s);
  EXPECT_EQ(receivers.longest(kFirstInstant + 10s, kFirstInstant), 10s);
  receivers.leave(first);
  EXPECT_EQ(receivers.longest(kFirstInstant + 10s, kFirstInstant), 7s);
  receivers.leave(second);
  EXPECT_EQ(receivers.longest(kFirstInstant + 10s, kFirstInstant), 0s);
}

TEST(Receivers, TimeInWhichTheProcessWasStoppedDoesNotCount) {
  Receivers receivers;
  receivers.enter(kFirstInstant);
  EXPECT_EQ(receivers.longest(kFirstInstant + 60s, kFirstInstant + 59s), 1s);
}

TEST(Receivers, MoreThreadsThanPlacesAreNotWatched) {
  Receivers receivers;
  for (int i = 0; i < 40; ++i) receivers.leave(receivers.enter(kFirstInstant));
  std::size_t last = 0;
  for (int i = 0; i < 40; ++i) last = receivers.enter(kFirstInstant);
  receivers.leave(last);
  EXPECT_EQ(receivers.longest(kFirstInstant + 1s, kFirstInstant), 1s);
}

}  // namespace
}  // namespace hecaton::bus
