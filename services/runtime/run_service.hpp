#pragma once
/// The steps of a service's main().

#include <functional>
#include <string>

#include "services/config/cell_file.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/shutdown.hpp"
#include "services/runtime/thread_priority.hpp"

namespace hecaton::services {

/// Parses the command line (see parse_options, also for `more`), takes over the signals and calls `body`. An exception
/// of `body` becomes one sentence on stderr and ExitCode::kBadInput, or kNoMemory for std::bad_alloc. Returns main's
/// result.
[[nodiscard]] int run_service(int argc, const char* const* argv, const std::string& description, Subject subject,
                              const std::function<void(const ServiceOptions&, ShutdownSignal&)>& body,
                              const MoreOptions& more = {});

/// From now on only this user can read the files that this process and its children make: logs, checkpoints and
/// recordings, which hold what a cell with keys encrypts.
void keep_files_private();

/// Reads the program and its libraries into memory and locks all present and future pages that are touched (mlockall(2)
/// with MCL_ONFAULT). Otherwise the kernel drops code that has not run for long, such as fault handling. A busy disk
/// has delayed its return by four seconds. Without the right (CAP_IPC_LOCK, or RLIMIT_MEMLOCK "unlimited") it logs the
/// reason and only reads the pages. Call it after LogScope is made and before a loop's first thread starts.
void lock_memory();

/// Makes the agent learn of this process's end at once. A sleeping thread takes over `fd`, the write end of a pipe, in
/// a descriptor table of its own. That thread dies before all others, so the agent reads an end of file within a
/// fraction of a millisecond. The kernel itself reports the end after the last thread is gone and the memory freed. On
/// a busy machine this is 10 to 330 ms after `kill -9`. When the kernel refuses the thread or the table, it logs the
/// reason, and the pipe closes with the process. Call it once, before the work begins; a negative `fd` does nothing.
void start_exit_notifier(int fd);

/// With `timing.real_time` in the cell file: gives the process's threads this priority (see raise_priority) and logs a
/// warning when that is refused. Call it right before the loop begins.
void raise_service_priority(const config::CellFile& file, ThreadPriority priority);

}  // namespace hecaton::services
