#pragma once
/// What `up` records of a running cell over time: contacts, tick times, use of the machine, and changes of the leading
/// supervisor.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <idl/health.h>
#include <idl/supervisor.h>
#include <idl/world.h>
#include <sys/types.h>

#include "services/cli/task_report.hpp"
#include "services/client/connection.hpp"

namespace hecaton::services::cli {

/// Sums up the reports of the contact monitor, also when a restarted world counts from 0 again.
class ContactTotals {
 public:
  void update(const msg::ContactReport& report);
  [[nodiscard]] std::uint64_t contacts() const { return before_ + contacts_; }
  [[nodiscard]] const std::optional<world::Separation>& smallest() const { return smallest_; }
  [[nodiscard]] double time() const { return time_; }  ///< of the last report, on the world's clock [s]

 private:
  std::uint64_t before_ = 0;    ///< contacts that earlier worlds counted
  std::uint64_t contacts_ = 0;  ///< contacts that the present world counted
  double time_ = 0.0;
  std::optional<world::Separation> smallest_;
};

/// Tick times of the planners, from heartbeats, each with quantiles over its planner's last 512 ticks.
class TickStatistics {
 public:
  void update(const msg::CellStatus& status);
  /// Medians over all windows of 512 ticks of all planners, and the longest tick. Empty without a window.
  [[nodiscard]] std::optional<Quantiles> typical() const;
  /// The greatest quantiles of any window. Empty without a window.
  [[nodiscard]] std::optional<Quantiles> worst() const;

 private:
  std::map<std::string, std::uint64_t> ticks_;  ///< of each planner, when its last window was taken
  std::vector<double> p50_, p99_;
  double max_ = 0.0;
};

/// Use of this machine by one process, from /proc.
struct ProcessUsage {
  double cpu_time = 0.0;             ///< user and system time since the process started [s]
  std::uint64_t rss_bytes = 0;       ///< resident now
  std::uint64_t peak_rss_bytes = 0;  ///< largest resident size so far
};

/// Empty when there is no such process.
[[nodiscard]] std::optional<ProcessUsage> process_usage(pid_t pid);

/// Processor time and memory of the cell's processes on this machine between begin() and end().
class UsageMonitor {
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

/// A table of the result of UsageMonitor::end.
[[nodiscard]] std::string usage_text(const Json& processes, const Palette& palette);

/// Follows which supervisor leads: the leader cannot report its own death. A pure function of events and time.
class SupervisorTracker {
 public:
  /// An event of any process. Returns a line to print, or an empty one. Events before the first status are ignored.
  [[nodiscard]] std::string on_process_event(const msg::ProcessEvent& event, bus::Clock::time_point now);
  /// The newest status; null: no supervisor has answered. Returns a line to print, or an empty one.
  [[nodiscard]] std::string on_status(const msg::CellStatus* status, bus::Clock::time_point now);

 private:
  /// Death of the leader, until another process answers.
  struct Death {
    std::int32_t pid = 0;
    bus::Clock::time_point at;
  };

  [[nodiscard]] bool is_of_dead_leader(const msg::CellStatus& status, bus::Clock::time_point now) const;

  std::string leader_;    ///< node that answered last; empty: none yet
  std::int32_t pid_ = 0;  ///< of the leader's process; 0: not known
  std::string standby_;   ///< node that is ready to take over; empty: none
  std::optional<Death> death_;
  bool silent_ = false;
};

/// SupervisorTracker, fed by the agents' events of a connection.
class SupervisorMonitor {
 public:
  explicit SupervisorMonitor(client::Connection& cell) : processes_(cell.participant(), &cell.mailbox()) {}

  /// Lines to print since the last call. `status`: the newest; null: no supervisor has answered.
  [[nodiscard]] std::vector<std::string> update(const msg::CellStatus* status);

 private:
  SupervisorTracker tracker_;
  bus::Reader<msg::ProcessEvent> processes_;
};

}  // namespace hecaton::services::cli
