#include "services/bus/deadlock_guard.hpp"

#include <cstdlib>
#include <mutex>

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

constexpr Clock::time_point kFirstInstant{1h};

TEST(ReceiverWatchdog, MeasuresNothingWhileNoThreadWorks) {
  ReceiverWatchdog receivers;
  receivers.leave(receivers.enter(kFirstInstant));
  EXPECT_EQ(receivers.longest(kFirstInstant + 1h, kFirstInstant), 0s);
}

TEST(ReceiverWatchdog, MeasuresTheSlowestThread) {
  ReceiverWatchdog receivers;
  const auto first = receivers.enter(kFirstInstant);
  const auto second = receivers.enter(kFirstInstant + 3s);
  EXPECT_EQ(receivers.longest(kFirstInstant + 10s, kFirstInstant), 10s);
  receivers.leave(first);
  EXPECT_EQ(receivers.longest(kFirstInstant + 10s, kFirstInstant), 7s);
  receivers.leave(second);
  EXPECT_EQ(receivers.longest(kFirstInstant + 10s, kFirstInstant), 0s);
}

TEST(ReceiverWatchdog, IgnoresTimeInWhichTheProcessWasStopped) {
  ReceiverWatchdog receivers;
  receivers.enter(kFirstInstant);
  EXPECT_EQ(receivers.longest(kFirstInstant + 60s, kFirstInstant + 59s), 1s);
}

TEST(ReceiverWatchdog, IgnoresThreadsBeyondItsSlots) {
  ReceiverWatchdog receivers;
  for (int i = 0; i < 40; ++i) receivers.leave(receivers.enter(kFirstInstant));
  std::size_t last = 0;
  for (int i = 0; i < 40; ++i) last = receivers.enter(kFirstInstant);
  receivers.leave(last);
  EXPECT_EQ(receivers.longest(kFirstInstant + 1s, kFirstInstant), 1s);
}

TEST(Removal, IsAwaited) {
  bool removed = false;
  EXPECT_TRUE(finishes_within(kRemovalLimit, [&] { removed = true; }));
  EXPECT_TRUE(removed);
}

/// As in Fast DDS, the destructor of a global object wants a lock that a deadlocked thread holds.
struct Global {
  ~Global() { mutex.lock(); }
  std::mutex mutex;
};

void return_with_a_deadlocked_removal(int exit_code) {
  static Global global;
  global.mutex.lock();
  if (finishes_within(10ms, [] { global.mutex.lock(); })) std::exit(1);
  std::exit(exit_code);
}

TEST(RemovalDeathTest, KeepsTheExitCodeOfAProcessWhoseRemovalDeadlocked) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(return_with_a_deadlocked_removal(7), testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace hecaton::bus
