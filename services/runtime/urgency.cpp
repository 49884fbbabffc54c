#include "services/runtime/urgency.hpp"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <string>

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

/// Niceness says nothing of a thread that has real-time priority, so it is what such threads are known by.
constexpr int kBehindLoops = 1;

/// 0: none, it stands back.
int priority_for(pid_t thread, Urgency urgency) {
  errno = 0;
  const int niceness = getpriority(PRIO_PROCESS, static_cast<id_t>(thread));
  if (errno != 0 || niceness > kBehindLoops) return 0;
  return static_cast<int>(niceness == kBehindLoops ? Urgency::kStart : urgency);
}

/// 0: none. Returns errno of why not; 0: it has it, or has ended meanwhile.
int give_priority(pid_t thread, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int policy = priority == 0 ? SCHED_OTHER : SCHED_RR;
  if (sched_setscheduler(thread, policy, &parameters) == 0 || errno == ESRCH) return 0;
  return errno;
}

/// Likewise. Looks again, for it may have come to its first line meanwhile and not go first after all.
int let_go_first(pid_t thread, Urgency urgency) {
  int given = 0;
  int error = 0;
  for (int due = priority_for(thread, urgency); due != given && error == 0; due = priority_for(thread, urgency)) {
    error = give_priority(thread, due);
    given = due;
  }
  return error;
}

}  // namespace

std::string go_first(Urgency urgency) {
  if (kExamined) return {};
  const int niceness = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
  if (niceness >= kBehindLoops) return "it was started to stand back, with niceness " + std::to_string(niceness);
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    const std::string name = entry.path().filename().string();
    pid_t thread = 0;
    std::from_chars(name.data(), name.data() + name.size(), thread);
    const int error = let_go_first(thread, urgency);
    if (error != 0) return std::strerror(error);
  }
  return {};
}

void start_behind_loops() {
  if (sched_getscheduler(0) == SCHED_RR) static_cast<void>(give_priority(0, static_cast<int>(Urgency::kStart)));
}

void stay_behind_loops() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kBehindLoops);
  start_behind_loops();  // it may have been started by a thread that goes first
}

void stand_back(int niceness) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness);  // before the rest, for go_first() to see
  static_cast<void>(give_priority(0, 0));                            // likewise
}

}  // namespace hecaton::services
