#include "services/runtime/progress_watchdog.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

class ProgressWatchdogTest : public ::testing::Test {
 protected:
  /// Updates every 10 ms for so long and returns the silence.
  ProgressWatchdog::Clock::duration run_for(ProgressWatchdog::Clock::duration time, bool busy, std::uint64_t finished) {
    for (const auto until = now_ + time; now_ < until;) watchdog_.update(now_ += 10ms, busy, finished);
    return watchdog_.silence();
  }
  ProgressWatchdog watchdog_;
  ProgressWatchdog::Clock::time_point now_{1h};
};

TEST_F(ProgressWatchdogTest, MeasuresSilenceOfABusyThread) {
  EXPECT_EQ(run_for(5s, false, 0), 0s);
  EXPECT_EQ(run_for(10ms, true, 0), 0s) << "it has just begun";
  EXPECT_EQ(run_for(3s, true, 0), 3s);
  EXPECT_EQ(run_for(10ms, true, 1), 0s) << "it has finished something";
  EXPECT_EQ(run_for(2s, true, 1), 2s);
  EXPECT_EQ(run_for(10ms, false, 1), 0s);
}

TEST_F(ProgressWatchdogTest, IgnoresTimeInWhichTheProcessWasStopped) {
  run_for(10ms, true, 0);
  now_ += 1h;  // the whole process was stopped
  EXPECT_EQ(run_for(10ms, true, 0), ProgressWatchdog::kLongestStep);
}

TEST_F(ProgressWatchdogTest, StallTextHasTheDuration) {
  EXPECT_EQ(stall_text("the thread that resolves goals", 5s, 5s), "");
  EXPECT_EQ(stall_text("the thread that resolves goals", 7900ms, 5s),
            "the thread that resolves goals has not answered for 7 s");
}

}  // namespace
}  // namespace hecaton::services
