#pragma once
/// Keeps a service's program and data in memory. The kernel drops pages of programs that were not run for a while; what
/// runs first when something has failed is just such code, and to read it back from a disk that others keep busy has
/// held a process for four seconds.

namespace hecaton::services {

/// Reads this program and its libraries into memory and locks all that the process has and will have there, as far as
/// it is touched (mlockall(2) with MCL_ONFAULT). Where that is not allowed (no CAP_IPC_LOCK, and RLIMIT_MEMLOCK below
/// "unlimited") it logs so and the process goes on without. After LogScope, before the first thread of a loop.
void lock_memory();

}  // namespace hecaton::services
