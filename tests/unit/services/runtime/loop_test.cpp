#include <chrono>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>

#include "services/bus/mailbox.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Time = std::chrono::steady_clock::time_point;

TEST(NextDeadline, KeepsTheGridWhileLateByLessThanAPeriod) {
  const Time start{100ms};
  EXPECT_EQ(next_deadline(start, start + 1ms, 10ms).at, start + 10ms);
  EXPECT_EQ(next_deadline(start, start + 13ms, 10ms).at, start + 10ms) << "3 ms late: the period is run at once";
  EXPECT_EQ(next_deadline(start, start + 13ms, 10ms).skipped, 0U);
}

TEST(NextDeadline, SkipsDeadlinesOfAStall) {
  const Time start{100ms};
  // Deadlines at +10, +20, +30, +40. At +37 those of +10 and +20 are skipped, and that of +30 is run 7 ms late.
  const NextDeadline next = next_deadline(start, start + 37ms, 10ms);
  EXPECT_EQ(next.at, start + 30ms);
  EXPECT_EQ(next.skipped, 2U);
}

TEST(PeriodicLoop, DoesNotCatchUpInABurst) {
  ShutdownSignal shutdown;
  PeriodicLoop loop(10ms, shutdown);
  ASSERT_TRUE(loop.next());
  const Time first = loop.now();
  std::this_thread::sleep_for(95ms);
  ASSERT_TRUE(loop.next());
  EXPECT_GE(loop.skipped(), 8U);
  // On any machine each later period begins on the grid, so k of them take at least (k − 1) periods.
  const Time after_stall = loop.now();
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(loop.next());
  EXPECT_GE(loop.now() - after_stall, 30ms);
  EXPECT_GE(loop.now() - first, 120ms);
  EXPECT_EQ(loop.statistics().ticks(), 5U);
  EXPECT_GE(loop.statistics().summary().tick_max_us, 95e3);
  EXPECT_GE(loop.statistics().summary().skipped, 8U);
}

TEST(PeriodicLoop, EndsAtASignal) {
  ShutdownSignal shutdown;
  PeriodicLoop loop(10ms, shutdown);
  ASSERT_TRUE(loop.next());
  raise(SIGTERM);
  EXPECT_TRUE(shutdown.requested());
  EXPECT_FALSE(loop.next());
}

TEST(ShutdownSignal, WakesTheMailbox) {
  ShutdownSignal shutdown;
  bus::Mailbox mailbox;
  shutdown.wake(&mailbox);
  EXPECT_FALSE(mailbox.wait(0ms));
  raise(SIGINT);
  EXPECT_TRUE(mailbox.wait(0ms));
  shutdown.wake(nullptr);
}

TEST(ShutdownSignal, IsNotRequestedAtFirst) {
  { ShutdownSignal().request(); }
  EXPECT_FALSE(ShutdownSignal().requested());
}

TEST(LoopStatistics, HasTheQuantilesOfItsTicks) {
  LoopStatistics statistics;
  for (int us = 100; us >= 1; --us) statistics.record_tick(std::chrono::microseconds(us));
  statistics.record_lateness(30us, 0);
  statistics.record_lateness(7us, 2);
  const LoopSummary summary = statistics.summary();
  EXPECT_EQ(summary.ticks, 100U);
  EXPECT_DOUBLE_EQ(summary.tick_p50_us, 50.0);
  EXPECT_DOUBLE_EQ(summary.tick_p99_us, 99.0);
  EXPECT_DOUBLE_EQ(summary.tick_max_us, 100.0);
  EXPECT_DOUBLE_EQ(summary.lateness_max_us, 30.0);
  EXPECT_EQ(summary.skipped, 2U);
}

TEST(LoopStatistics, ForgetsPeriodsBeforeItsWindow) {
  LoopStatistics statistics;
  statistics.record_tick(1s);
  statistics.record_lateness(1s, 0);
  for (std::size_t k = 0; k < LoopStatistics::kWindow; ++k) {
    statistics.record_tick(5us);
    statistics.record_lateness(2us, 0);
  }
  EXPECT_DOUBLE_EQ(statistics.summary().tick_max_us, 5.0);
  EXPECT_DOUBLE_EQ(statistics.lateness_max_us(), 2.0);
  EXPECT_EQ(statistics.ticks(), LoopStatistics::kWindow + 1);
}

TEST(LoopStatistics, IsZeroWithoutTicks) {
  EXPECT_EQ(LoopStatistics().summary().tick_max_us, 0.0);
  EXPECT_EQ(LoopStatistics().lateness_max_us(), 0.0);
}

TEST(PeriodicLoop, BeginsAPeriodEarlyWhenItIsDue) {
  ShutdownSignal shutdown;
  PeriodicLoop loop(1h, shutdown);
  bus::Mailbox mailbox;
  ASSERT_TRUE(loop.next());
  const Time first = loop.now();
  int asked = 0;
  mailbox.notify();
  ASSERT_TRUE(loop.next(mailbox, [&] {
    if (++asked == 1) mailbox.notify();
    return asked == 2;
  }));
  EXPECT_EQ(asked, 2) << "an arrival that is not due does not begin the period";
  EXPECT_LT(loop.now(), first + 30min);
  EXPECT_EQ(loop.skipped(), 0U);
}

}  // namespace
}  // namespace hecaton::services
