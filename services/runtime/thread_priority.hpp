#pragma once
/// Which threads run first when processors are short (docs/explanation/0016-thread-priority.md). Standard library and
/// system calls only.

#include <optional>
#include <string>

namespace hecaton::services {

/// Real-time priorities of SCHED_RR, see sched(7). They are far below the kernel's own threads (50). A supervising
/// process is above the processes that it supervises, so that it can still stop a loop that never sleeps.
enum class ThreadPriority : int {
  kStartup = 5,   ///< processes that start, and threads that may wait for a disk: below all loops
  kControl = 10,  ///< planners, the world
  kSafety = 11,   ///< drivers, the supervisor: little work, and the reaction to faults
  kAgent = 12,    ///< agents
};

/// Gives all present threads of the process, and the threads that they start later, this priority. Threads that called
/// lower_priority() or keep_startup_priority() keep theirs. Returns why that is refused (neither CAP_SYS_NICE nor a
/// sufficient RLIMIT_RTPRIO, or a process started with nice), or nothing. Does nothing under sanitizers, whose
/// slow processes would leave no processor to others.
[[nodiscard]] std::optional<std::string> raise_priority(ThreadPriority priority);

/// In a child between fork and exec: lowers a real-time priority to kStartup. System calls only.
void lower_child_priority();

/// Gives the calling thread kStartup for good, whatever raise_priority() does. For the first line of threads that may
/// wait for a disk while another thread waits for them.
void keep_startup_priority();

/// Takes the calling thread out of real-time scheduling for good and sets its niceness (2 to 19). For the first line of
/// threads with long computations, so that loops and other processes come first.
void lower_priority(int niceness);

/// For the first line of threads that only show what others do, in programs without real-time priority. The calling
/// thread and those that it starts later interrupt no running thread when they wake (SCHED_BATCH). Of a processor that
/// is short they get a third of what a loop gets, so that they still answer.
void give_way();

}  // namespace hecaton::services
