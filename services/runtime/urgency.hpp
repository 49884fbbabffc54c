#pragma once
/// Who goes first when processors are short: loops that keep a cell safe, and the middleware's threads that feed them,
/// before everything else on the machine (docs/design/0018-urgency.md). Standard library and system calls only.

#include <string>

namespace hecaton::services {

/// Real-time priorities, sched(7): far below those of the kernel's own threads (50), and whoever watches above whom it
/// watches, so that a loop that never sleeps is still found and killed.
enum class Urgency : int {
  kStart = 5,    ///< who has no loop yet: before all that is not urgent, and in no loop's way
  kWork = 10,    ///< planners, the world
  kSafety = 11,  ///< drivers, the supervisor: little to do, and others' faults to answer
  kWatch = 12,   ///< agents
};

/// Gives all threads that the process has now, and those that they start, this priority (SCHED_RR), but for those that
/// stay behind or stand back. Returns why it cannot be (neither CAP_SYS_NICE nor a sufficient RLIMIT_RTPRIO; all of the
/// process stands back, as after `nice`; empty: it is so); then whether the process is in time depends on the machine's
/// other work. At the beginning of a loop, for to start takes longer than any turn. Does nothing in programs that are
/// slowed down to be examined (sanitizers), which would leave the machine to nobody else.
[[nodiscard]] std::string go_first(Urgency urgency);

/// In a child between fork and exec: who goes first is started by somebody who does, too, but in no loop's way. System
/// calls only.
void start_behind_loops();

/// For the first line of a thread whose work somebody waits for, and which may wait for a disk itself: it has the
/// priority of a start, whatever its process goes on to.
void stay_behind_loops();

/// For the first line of a thread that works for a loop for long: loops go first, and so do other processes, the more
/// the larger `niceness` is (2 to 19).
void stand_back(int niceness);

}  // namespace hecaton::services
