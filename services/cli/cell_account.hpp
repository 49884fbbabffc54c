#pragma once
/// What a running cell's nodes and referee say over time, summed up for a report.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <idl/supervisor.h>
#include <idl/world.h>
#include <sys/types.h>

#include "services/cli/report.hpp"

namespace hecaton::services::cli {

/// What a process of this machine costs, from /proc.
struct ProcessUsage {
  double cpu_time = 0.0;             ///< user and system, since it started [s]
  std::uint64_t rss_bytes = 0;       ///< resident now
  std::uint64_t peak_rss_bytes = 0;  ///< the most that ever was
};

/// Nothing when there is no such process.
[[nodiscard]] std::optional<ProcessUsage> process_usage(pid_t pid);

/// The referee's account, also across a restart of the world that could not go on with the old one.
class RefereeAccount {
 public:
  void update(const msg::RefereeReport& report);
  [[nodiscard]] std::uint64_t contacts() const { return before_ + contacts_; }
  [[nodiscard]] const std::optional<world::Separation>& smallest() const { return smallest_; }
  [[nodiscard]] double time() const { return time_; }  ///< of the last report, on the world's clock [s]

 private:
  std::uint64_t before_ = 0;    ///< contacts in the accounts of worlds that are gone
  std::uint64_t contacts_ = 0;  ///< in the present one's
  double time_ = 0.0;
  std::optional<world::Separation> smallest_;
};

/// Tick times of the planners, from heartbeats: each tells quantiles over its last 512 ticks.
class TickAccount {
 public:
  void update(const msg::CellStatus& status);
  /// Medians over all such windows of all planners, and the longest tick of all.
  [[nodiscard]] std::optional<Quantiles> typical() const;
  /// The worst window.
  [[nodiscard]] std::optional<Quantiles> worst() const;

 private:
  std::map<std::string, std::uint64_t> ticks_;  ///< of each planner, when its last window was taken
  std::vector<double> p50_, p99_;
  double max_ = 0.0;
};

/// Processor time and memory of the cell's processes on this machine, between two moments.
class UsageAccount {
 public:
  void begin(const msg::CellStatus& status);
  /// [{"node", "pid", "cpu_percent", "rss_bytes", "peak_rss_bytes"}]; 100 % is one core.
  [[nodiscard]] Json end(const msg::CellStatus& status) const;

 private:
  struct Start {
    double wall = 0.0;  ///< [s]
    ProcessUsage usage;
  };
  std::map<long long, Start> starts_;  ///< by pid
};

/// A table of what UsageAccount::end returned.
[[nodiscard]] std::string usage_text(const Json& processes, const Palette& palette);

}  // namespace hecaton::services::cli
