// Priorities stay, so the test runs in a process of its own.
#include "services/runtime/thread_priority.hpp"

#include <atomic>
#include <cstdlib>
#include <latch>
#include <thread>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

bool may_raise() {
  sched_param parameters{};
  parameters.sched_priority = static_cast<int>(ThreadPriority::kAgent);
  return !kSanitized && sched_setscheduler(0, SCHED_RR, &parameters) == 0;
}

bool has(ThreadPriority priority) {
  sched_param parameters{};
  return sched_getscheduler(0) == SCHED_RR && sched_getparam(0, &parameters) == 0 &&
         parameters.sched_priority == static_cast<int>(priority);
}

bool is_lowered(int niceness) {
  return sched_getscheduler(0) == SCHED_OTHER && getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())) == niceness;
}

/// Returns a bit for each wrong priority.
int wrong_priorities(bool may) {
  std::latch begun(3);
  std::latch raised(1);
  std::atomic<int> wrong = 0;
  std::thread plain([&] {
    begun.count_down();
    raised.wait();
    if (has(ThreadPriority::kSafety) != may) wrong |= 1;
  });
  std::thread lowered([&] {
    lower_priority(10);
    begun.count_down();
    raised.wait();
    if (!is_lowered(10)) wrong |= 2;
  });
  std::thread writer([&] {
    keep_startup_priority();
    begun.count_down();
    raised.wait();
    if (has(ThreadPriority::kStartup) != may) wrong |= 128;
  });
  begun.wait();
  if (!raise_priority(ThreadPriority::kSafety) != (may || kSanitized)) wrong |= 32;
  raised.count_down();
  if (has(ThreadPriority::kSafety) != may) wrong |= 4;
  std::thread later([&] {
    if (has(ThreadPriority::kSafety) != may) wrong |= 8;
    keep_startup_priority();
    if (has(ThreadPriority::kStartup) != may) wrong |= 16;
    lower_priority(2);
    if (!is_lowered(2)) wrong |= 64;
  });
  for (std::thread* thread : {&plain, &lowered, &writer, &later}) thread->join();
  return wrong;
}

TEST(ThreadPriorityDeathTest, RaisesAllThreadsButThoseThatLoweredThemselves) {
  EXPECT_EXIT(
      {
        const bool may = may_raise();
        lower_priority(0);
        std::exit(wrong_priorities(may));
      },
      ::testing::ExitedWithCode(0), "");
}

TEST(ThreadPriority, GivesWayWithTheThreadsThatItStartsLater) {
  const auto gives_way = [] {
    return sched_getscheduler(0) == SCHED_BATCH && getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())) >= 5;
  };
  bool first = false;
  bool later = false;
  std::thread([&] {
    give_way();
    first = gives_way();
    std::thread([&] { later = gives_way(); }).join();
  }).join();
  EXPECT_TRUE(first);
  EXPECT_TRUE(later);
  EXPECT_NE(sched_getscheduler(0), SCHED_BATCH) << "the thread that started it stays as it was";
}

}  // namespace
}  // namespace hecaton::services
