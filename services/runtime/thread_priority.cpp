#include "services/runtime/thread_priority.hpp"

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
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// Niceness has no effect on real-time threads, so this value marks those that keep kStartup.
constexpr int kStartupNiceness = 1;

/// The priority that the thread is due; 0: none, it called lower_priority().
int priority_for(pid_t thread, ThreadPriority priority) {
  errno = 0;
  const int niceness = getpriority(PRIO_PROCESS, static_cast<id_t>(thread));
  if (errno != 0 || niceness > kStartupNiceness) return 0;
  return static_cast<int>(niceness == kStartupNiceness ? ThreadPriority::kStartup : priority);
}

/// 0: no real-time priority. Returns errno's value; 0: done, or the thread has ended.
int set_priority(pid_t thread, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int policy = priority == 0 ? SCHED_OTHER : SCHED_RR;
  if (sched_setscheduler(thread, policy, &parameters) == 0 || errno == ESRCH) return 0;
  return errno;
}

/// Returns as set_priority(). Checks again afterwards: the thread may have marked itself meanwhile.
int raise_thread(pid_t thread, ThreadPriority priority) {
  int given = 0;
  int error = 0;
  for (int due = priority_for(thread, priority); due != given && error == 0; due = priority_for(thread, priority)) {
    error = set_priority(thread, due);
    given = due;
  }
  return error;
}

}  // namespace

std::optional<std::string> raise_priority(ThreadPriority priority) {
  if (kSanitized) return std::nullopt;
  const int niceness = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
  if (niceness >= kStartupNiceness) return "the process was started with niceness " + std::to_string(niceness);
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    const std::string name = entry.path().filename().string();
    pid_t thread = 0;
    std::from_chars(name.data(), name.data() + name.size(), thread);
    const int error = raise_thread(thread, priority);
    if (error != 0) return std::strerror(error);
  }
  return std::nullopt;
}

void lower_child_priority() {
  if (sched_getscheduler(0) == SCHED_RR) static_cast<void>(set_priority(0, static_cast<int>(ThreadPriority::kStartup)));
}

void keep_startup_priority() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kStartupNiceness);
  lower_child_priority();  // a thread inherits the priority of the thread that starts it
}

void lower_priority(int niceness) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness);  // first: raise_priority() looks for it
  static_cast<void>(set_priority(0, 0));
}

void give_way() {
  constexpr int kNiceness = 5;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNiceness);
  const sched_param parameters{};
  static_cast<void>(sched_setscheduler(0, SCHED_BATCH, &parameters));
}

}  // namespace hecaton::services
