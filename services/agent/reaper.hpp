#pragma once
/// Takes dead children off the kernel's list. In that the kernel may wait in circles for whoever uses their entries in
/// /proc: a loop that goes before those never comes back. Stalls of 1 s at higher niceness, and for good with real-time
/// priority, were seen on Linux 6.18 (release_task, shrink_dcache_parent).

#include <thread>

#include <sys/types.h>

namespace hecaton::services {

class Reaper {
 public:
  /// Throws std::runtime_error with a sentence when there can be no pipe.
  Reaper();
  /// Waits until it has reaped what it was given.
  ~Reaper();
  Reaper(const Reaper&) = delete;
  Reaper& operator=(const Reaper&) = delete;

  /// Of a child that has ended or is about to. Never waits: by a pipe, for a lock could be held by the thread, which
  /// stands back.
  void take(pid_t child) const;

 private:
  void work() const;

  int begin_ = -1;
  int end_ = -1;
  std::thread thread_;
};

}  // namespace hecaton::services
