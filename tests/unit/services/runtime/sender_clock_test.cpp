#include "services/runtime/sender_clock.hpp"

#include <chrono>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

using Clock = SenderClock::Clock;

constexpr std::int64_t kOtherEpoch = 77'000'000'000'000;  // offset of the sender's clock [ns]

struct SenderClockTest : ::testing::Test {
  /// Age on arrival of a sample that is sent at `at` with latency `transit`.
  std::chrono::nanoseconds age_on_arrival(std::chrono::nanoseconds at, std::chrono::nanoseconds transit) {
    const Clock::time_point received{5h + at + transit};
    return received - clock.sent(kOtherEpoch + at.count(), received);
  }
  SenderClock clock;
};

TEST_F(SenderClockTest, RemovesOffsetAndSmallestLatency) {
  EXPECT_EQ(age_on_arrival(0ms, 3ms), 0ms);
  EXPECT_EQ(age_on_arrival(10ms, 3ms), 0ms);
}

TEST_F(SenderClockTest, CountsAdditionalLatencyAsAge) {
  (void)age_on_arrival(0ms, 3ms);
  EXPECT_EQ(age_on_arrival(10ms, 43ms), 40ms);
  EXPECT_EQ(age_on_arrival(20ms, 2ms), 0ms);  // the smallest latency from now on
  EXPECT_EQ(age_on_arrival(30ms, 3ms), 1ms);
}

TEST_F(SenderClockTest, FollowsADriftingClock) {
  // The sender's clock loses 50 µs a second against ours: samples seem to be ever later.
  std::chrono::nanoseconds worst{};
  for (int k = 0; k < 6000; ++k) {
    const std::chrono::nanoseconds at = k * 10ms;
    worst = std::max(worst, age_on_arrival(at, 1ms + at / 20'000));
  }
  EXPECT_LE(worst, 1ms);  // 20 s of drift at most, where one minute has 3 ms
  EXPECT_GE(worst, 900us);
}

TEST_F(SenderClockTest, ForgetsWithinTwoWindowsThatTheClockStoodStill) {
  SenderClock robot(2s);
  const auto delay = [&](Clock::duration now, Clock::duration stamp) {
    const Clock::time_point received{now};
    return received - robot.sent(std::chrono::nanoseconds(stamp).count(), received);
  };
  for (int k = 0; k < 2000; ++k) EXPECT_EQ(delay(k * 2ms, 100s + k * 2ms), 0s);
  EXPECT_EQ(delay(4010ms, 103'990ms), 20ms) << "late on its way";
  Clock::duration last{};
  for (int k = 0; k < 2500; ++k) {
    last = delay(4400ms + k * 2ms, 104'100ms + k * 2ms);
    EXPECT_LE(last, 300ms);
  }
  EXPECT_EQ(last, 0s) << "after 5 s";
}

TEST_F(SenderClockTest, AcceptsExtremeStamps) {
  const Clock::time_point received{5h};
  for (const std::int64_t stamp :
       {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    EXPECT_LE(clock.sent(stamp, received), received);
  }
}

}  // namespace
}  // namespace hecaton::services
