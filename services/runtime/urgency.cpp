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

/// errno of why not; 0: it has it, or has ended meanwhile.
int give_priority(pid_t thread, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  if (sched_setscheduler(thread, SCHED_RR, &parameters) == 0 || errno == ESRCH) return 0;
  return errno;
}

}  // namespace

std::string go_first(Urgency urgency) {
  if (kExamined) return {};
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    const std::string name = entry.path().filename().string();
    pid_t thread = 0;
    std::from_chars(name.data(), name.data() + name.size(), thread);
    const int priority = priority_for(thread, urgency);
    const int error = priority > 0 ? give_priority(thread, priority) : 0;
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
  const sched_param none{};
  static_cast<void>(sched_setscheduler(0, SCHED_OTHER, &none));  // likewise
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness);
}

}  // namespace hecaton::services
