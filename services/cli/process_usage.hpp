#pragma once
/// What processes of this machine cost, from /proc.

#include <cstdint>
#include <optional>

#include <sys/types.h>

namespace hecaton::services::cli {

struct ProcessUsage {
  double cpu_time = 0.0;             ///< user and system, since it started [s]
  std::uint64_t rss_bytes = 0;       ///< resident now
  std::uint64_t peak_rss_bytes = 0;  ///< the most that ever was
};

/// Nothing when there is no such process.
[[nodiscard]] std::optional<ProcessUsage> process_usage(pid_t pid);

}  // namespace hecaton::services::cli
