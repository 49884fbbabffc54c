#pragma once
/// Takes dead children off the kernel's list. In that the kernel may wait in circles for whoever uses their entries in
/// /proc: a loop that goes before those never comes back. Stalls of 1 s at higher niceness, and for good with real-time
/// priority, were seen on Linux 6.18 (release_task, shrink_dcache_parent).

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include <sys/types.h>

namespace hecaton::services {

class Reaper {
 public:
  Reaper() : thread_([this] { work(); }) {}
  /// Waits until it has reaped what it was given.
  ~Reaper();
  Reaper(const Reaper&) = delete;
  Reaper& operator=(const Reaper&) = delete;

  /// Of a child that has ended.
  void take(pid_t child);

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<pid_t> children_;
  bool ending_ = false;
  std::thread thread_;  ///< last: everything it uses exists before it starts
};

}  // namespace hecaton::services
