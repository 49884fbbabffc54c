#pragma once
/// Keeps the services of a host running: starts them, detects exits and hangs, restarts them, ends them. It knows no
/// network: the caller gets what happened as events.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <poll.h>

#include "services/agent/child_process.hpp"
#include "services/agent/service_plan.hpp"

namespace hecaton::services {

struct RestartLimits {
  std::chrono::nanoseconds first = std::chrono::milliseconds(100);  ///< delay after an exit, doubled with each in a row
  std::chrono::nanoseconds longest = std::chrono::seconds(5);       ///< delay
  std::chrono::nanoseconds steady = std::chrono::seconds(10);       ///< a longer uptime begins a new row
  int attempts = 10;                                                ///< restarts in a row; 0: never restarts
  /// After `attempts` the process is started again in this interval, since the cause may be gone; 0: never.
  std::chrono::nanoseconds retry = std::chrono::seconds(60);
};

/// When a process that exited is started again.
class RestartPolicy {
 public:
  explicit RestartPolicy(const RestartLimits& limits) : limits_(limits) {}

  /// The process exited after `uptime`: the delay until it is started again; empty: no attempt is left.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> delay_after(std::chrono::nanoseconds uptime) {
    if (uptime >= limits_.steady) attempts_ = 0;
    if (attempts_ >= limits_.attempts) return std::nullopt;
    auto delay = limits_.first;
    for (int i = 0; i < attempts_ && delay < limits_.longest; ++i) delay *= 2;
    ++attempts_;
    return std::min(delay, limits_.longest);
  }

  [[nodiscard]] int attempts() const { return attempts_; }  ///< in a row

 private:
  RestartLimits limits_;
  int attempts_ = 0;
};

/// Of memory that is allocated and not used, such as the stacks of 120 threads [byte].
inline constexpr std::uint64_t kMemoryMargin = 1'000'000'000;

struct ProcessManagerOptions {
  std::filesystem::path programs;  ///< folder of the executables
  std::filesystem::path logs;      ///< folder of the services' logs; empty: they write to the agent's streams
  RestartLimits restart;
  /// A process whose loop sends no heartbeat for this long is killed; 0: heartbeats are not checked.
  std::chrono::nanoseconds watchdog{0};
  /// A process without a first heartbeat within this is killed, with an uptime of 0; 0: no limit.
  std::chrono::nanoseconds start_limit{0};
  /// A process that uses more memory is killed [byte]; 0: no limit. Other processes keep theirs. The kernel refuses a
  /// process what it would allocate beyond kMemoryMargin more, because the memory is looked at ten times a second only.
  std::uint64_t memory_limit = 0;
  bool exit_notifiers = false;  ///< processes get an exit notifier (services/runtime/run_service.hpp)
};

/// Why the manager has killed a process.
enum class KillReason { kNone, kHung, kTooLarge };

struct ProcessEvent {
  enum class Kind { kStarted, kExited, kNotStarted, kGivenUp, kKilled };
  Kind kind{};
  const PlannedService* service = nullptr;
  pid_t pid = 0;
  ChildEnd end;                           ///< kExited
  bool wanted = false;                    ///< kExited: the process was ordered to end
  unsigned restarts = 0;                  ///< so far
  KillReason killed = KillReason::kNone;  ///< kKilled, and kExited after it
  std::string reason;                     ///< of kNotStarted, kGivenUp and kKilled, and of kExited after that
};

/// One thread: children end with the thread that started them.
class ProcessManager {
 public:
  using Clock = std::chrono::steady_clock;

  ProcessManager(std::vector<PlannedService> services, ProcessManagerOptions options);

  /// Starts processes that are due, reports exits, kills processes that hang or use too much memory. An exit is
  /// reported as soon as it is certain; the restart waits until the process is gone.
  [[nodiscard]] std::vector<ProcessEvent> turn(Clock::time_point now);
  /// Sends SIGTERM to all processes. There are no restarts any more.
  void terminate_all();
  void kill_all();

  /// Appends descriptors that become readable when turn() has a start or an exit to report.
  void append_descriptors(std::vector<pollfd>& descriptors) const;
  /// When the next restart is due.
  [[nodiscard]] std::optional<Clock::time_point> next_start() const;
  [[nodiscard]] bool all_ended() const;
  /// No process has failed to start or is given up.
  [[nodiscard]] bool healthy() const;
  /// "planner-arm1 was given up after 10 restarts in a row, and is tried again every 60 s (2 times so far)"; empty
  /// while healthy().
  [[nodiscard]] std::string problem() const;

 private:
  struct Process {
    PlannedService service;
    RestartPolicy policy;
    std::optional<ChildProcess> child{};
    std::optional<Clock::time_point> start_at{};
    Clock::time_point started{};
    std::optional<Clock::time_point> first_heartbeat{};
    Clock::time_point silent_since{};  // last heartbeat, start, or end of an absence of this process
    KillReason killed = KillReason::kNone;
    std::string kill_text{};  // why, for people
    bool starting = false;    // its program is being loaded
    bool exit_reported = false;
    unsigned starts = 0;
    bool given_up = false;
    unsigned retries = 0;                        // since it was given up
    std::optional<std::string> start_failure{};  // of the last start
  };
  using Events = std::vector<ProcessEvent>;
  void start(Process& process, Clock::time_point now, Events& events);
  void check_start(Process& process, Clock::time_point now, Events& events);
  void report_start_failure(Process& process, const std::string& why, Clock::time_point now, Events& events);
  void check_exit(Process& process, Clock::time_point now, Events& events);
  void report_exit(Process& process, const ChildEnd& end, Events& events) const;
  void check_heartbeats(Process& process, Clock::time_point now, Events& events);
  void check_memory(Process& process, Events& events) const;
  void kill(Process& process, KillReason reason, std::string text, Events& events) const;
  void plan_restart(Process& process, Clock::time_point now, Events& events);
  void reset_retries(Process& process, Clock::time_point now) const;
  [[nodiscard]] std::chrono::nanoseconds uptime(const Process& process, Clock::time_point now) const;
  [[nodiscard]] ProcessEvent event(const Process& process, ProcessEvent::Kind kind) const;

  ProcessManagerOptions options_;
  Reaper reaper_;
  std::vector<Process> processes_;
  Clock::time_point checked_{};         // heartbeats, last
  Clock::time_point memory_checked_{};  // last
  bool ending_ = false;
};

}  // namespace hecaton::services
