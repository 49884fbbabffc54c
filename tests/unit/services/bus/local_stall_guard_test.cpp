#include "services/bus/local_stall_guard.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

constexpr Clock::time_point kBegin{1h};

/// A process that updates its guard every 50 ms while it runs.
struct Process {
  LocalStallGuard guard{2s, kBegin};
  Clock::time_point now = kBegin;

  /// True when the guard detected a long stall meanwhile.
  bool run_for(Clock::duration duration) {
    bool long_stall = false;
    for (const auto end = now + duration; now < end;) {
      now += LocalStallGuard::kPeriod;
      long_stall = guard.update(now) || long_stall;
    }
    return long_stall;
  }
};

TEST(LocalStallGuard, DoesNotIsolateARunningProcess) {
  Process process;
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(process.run_for(50ms));
    EXPECT_FALSE(process.guard.isolated(process.now + 49ms));
    EXPECT_EQ(process.guard.arrival(process.now + 49ms), process.now + 49ms);
  }
}

TEST(LocalStallGuard, ToleratesGapsOfABusyMachine) {
  Process process;
  EXPECT_FALSE(process.guard.isolated(process.now + 126ms));
  EXPECT_FALSE(process.guard.update(process.now + 126ms));
  EXPECT_FALSE(process.guard.isolated(process.now + 127ms));
}

TEST(LocalStallGuard, DiscardsOnlyTheBacklogAfterAShortStall) {
  Process process;
  process.run_for(1s);
  const auto before = process.now;
  process.now += 600ms;
  EXPECT_TRUE(process.guard.isolated(process.now)) << "also before update()";
  EXPECT_EQ(process.guard.arrival(process.now), before) << "a sample that is read now arrived before the stall";
  EXPECT_FALSE(process.guard.long_stall(process.now));
  EXPECT_FALSE(process.guard.update(process.now));
  EXPECT_TRUE(process.guard.isolated(process.now + 19ms));
  EXPECT_FALSE(process.guard.isolated(process.now + 20ms));
}

// The peers' lease of 2 s began with the last data that they received, before the stall. The own lease of their
// participants began no later than now.
TEST(LocalStallGuard, IsolatesUntilBothLeasesAreOverAfterALongStall) {
  Process process;
  process.run_for(1s);
  process.now += 1100ms;
  EXPECT_TRUE(process.guard.long_stall(process.now));
  const auto woken = process.now;
  EXPECT_TRUE(process.guard.update(process.now));
  EXPECT_FALSE(process.guard.long_stall(process.now));
  EXPECT_FALSE(process.run_for(2450ms)) << "one stall is reported once";
  EXPECT_TRUE(process.guard.isolated(woken + 2450ms));
  process.run_for(50ms);
  EXPECT_FALSE(process.guard.isolated(woken + 2500ms));
}

TEST(LocalStallGuard, NeedsAStallForALongStallHoweverShortTheLease) {
  LocalStallGuard guard{20ms, kBegin};
  EXPECT_FALSE(guard.long_stall(kBegin + 200ms));
  EXPECT_TRUE(guard.long_stall(kBegin + 300ms));
}

}  // namespace
}  // namespace hecaton::bus
