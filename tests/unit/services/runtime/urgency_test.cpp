// In a process of its own: who goes first stays so.

#include "services/runtime/urgency.hpp"

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
constexpr bool kExamined = true;
#else
constexpr bool kExamined = false;
#endif

bool may_go_first() {
  sched_param parameters{};
  parameters.sched_priority = static_cast<int>(Urgency::kWatch);
  return !kExamined && sched_setscheduler(0, SCHED_RR, &parameters) == 0;
}

bool has(Urgency urgency) {
  sched_param parameters{};
  return sched_getscheduler(0) == SCHED_RR && sched_getparam(0, &parameters) == 0 &&
         parameters.sched_priority == static_cast<int>(urgency);
}

bool stands_back(int niceness) {
  return sched_getscheduler(0) == SCHED_OTHER && getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())) == niceness;
}

/// Each bit is something that is not as it should be.
int what_is_wrong(bool may) {
  std::latch begun(3);
  std::latch gone_first(1);
  std::atomic<int> wrong = 0;
  std::thread plain([&] {
    begun.count_down();
    gone_first.wait();
    if (has(Urgency::kSafety) != may) wrong |= 1;
  });
  std::thread behind([&] {
    stand_back(10);
    begun.count_down();
    gone_first.wait();
    if (!stands_back(10)) wrong |= 2;
  });
  std::thread writer([&] {
    stay_behind_loops();
    begun.count_down();
    gone_first.wait();
    if (has(Urgency::kStart) != may) wrong |= 128;
  });
  begun.wait();
  if (go_first(Urgency::kSafety).empty() != (may || kExamined)) wrong |= 32;
  gone_first.count_down();
  if (has(Urgency::kSafety) != may) wrong |= 4;
  std::thread later([&] {
    if (has(Urgency::kSafety) != may) wrong |= 8;
    stay_behind_loops();
    if (has(Urgency::kStart) != may) wrong |= 16;
    stand_back(2);
    if (!stands_back(2)) wrong |= 64;
  });
  for (std::thread* thread : {&plain, &behind, &writer, &later}) thread->join();
  return wrong;
}

TEST(UrgencyDeathTest, AllThreadsGoFirstButThoseThatStandBackWhereItIsAllowed) {
  EXPECT_EXIT(
      {
        const bool may = may_go_first();
        stand_back(0);
        std::exit(what_is_wrong(may));
      },
      ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace hecaton::services
