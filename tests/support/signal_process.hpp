#pragma once
/// Signals to other processes of a test.

#include <csignal>

#include <sys/types.h>

namespace hecaton::test {

/// kill(2) for one process. Rejects 0 and −1, which would signal the test's own group or all processes.
[[nodiscard]] inline bool signal_process(pid_t pid, int signal) {
  return pid > 0 && kill(pid, signal) == 0;
}

}  // namespace hecaton::test
