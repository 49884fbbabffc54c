#include "services/planner/sender_clock.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Clock = SenderClock::Clock;

constexpr std::int64_t kOtherEpoch = 77'000'000'000'000;  // the sender's clock began at another time [ns]

struct SenderClockTest : ::testing::Test {
  /// Of a sample sent `at` after both clocks' common instant that travelled `transit`: its age on arrival.
  std::chrono::nanoseconds age_on_arrival(std::chrono::nanoseconds at, std::chrono::nanoseconds transit) {
    const Clock::time_point received{5h + at + transit};
    return received - clock.sent(kOtherEpoch + at.count(), received);
  }
  SenderClock clock;
};

TEST_F(SenderClockTest, OffsetAndQuickestTransitCancel) {
  EXPECT_EQ(age_on_arrival(0ms, 3ms), 0ms);
  EXPECT_EQ(age_on_arrival(10ms, 3ms), 0ms);
}

TEST_F(SenderClockTest, WhatASampleIsDelayedMoreIsItsAge) {
  (void)age_on_arrival(0ms, 3ms);
  EXPECT_EQ(age_on_arrival(10ms, 43ms), 40ms);
  EXPECT_EQ(age_on_arrival(20ms, 2ms), 0ms);  // quicker than ever: the measure from now on
  EXPECT_EQ(age_on_arrival(30ms, 3ms), 1ms);
}

TEST_F(SenderClockTest, FollowsAClockThatDrifts) {
  // The sender's clock loses 50 µs a second against ours: samples seem to be ever later.
  std::chrono::nanoseconds worst{};
  for (int k = 0; k < 6000; ++k) {
    const std::chrono::nanoseconds at = k * 10ms;
    worst = std::max(worst, age_on_arrival(at, 1ms + at / 20'000));
  }
  EXPECT_LE(worst, 1ms);  // 20 s of drift at most, where one minute has 3 ms
  EXPECT_GE(worst, 900us);
}

TEST_F(SenderClockTest, NoStampOverflows) {
  const Clock::time_point received{5h};
  for (const std::int64_t stamp :
       {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    EXPECT_LE(clock.sent(stamp, received), received);
  }
}

}  // namespace
}  // namespace hecaton::services
