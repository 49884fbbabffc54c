#pragma once
/// Signals to other processes of a test.

#include <csignal>

#include <sys/types.h>

namespace hecaton::test {

/// kill(2) of one process. What a test failed to find out (0, −1) would reach the test's own group, or everybody.
[[nodiscard]] inline bool signal_process(pid_t pid, int signal) {
  return pid > 0 && kill(pid, signal) == 0;
}

}  // namespace hecaton::test
