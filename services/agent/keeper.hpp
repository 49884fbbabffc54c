#pragma once
/// Keeps a list of services running: starts them, notices their deaths, starts them again, ends them. Knows no network:
/// what happens is returned to the caller. One thread: children end with the thread that started them.

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <poll.h>

#include "services/agent/child_process.hpp"
#include "services/agent/reaper.hpp"
#include "services/agent/restart_policy.hpp"
#include "services/agent/service_plan.hpp"

namespace hecaton::services {

struct KeeperOptions {
  std::filesystem::path programs;  ///< folder of the executables
  std::filesystem::path logs;      ///< folder of the services' logs; empty: they go where ours goes
  RestartLimits restart;
  /// Who told of itself, and then does not for this long, is killed; 0: nobody is, nor is `start_limit` looked at.
  std::chrono::nanoseconds watchdog{0};
  /// So is who did not tell of itself for this long after it was started, which counts as no life at all; 0: nobody.
  std::chrono::nanoseconds start_limit{0};
  bool life_lines = false;  ///< services are given one, services/runtime/life_line.hpp
};

/// Something happened to a service.
struct Incident {
  enum class Kind { kStarted, kExited, kNotStarted, kGivenUp, kHung };
  Kind kind{};
  const PlannedService* service = nullptr;
  pid_t pid = 0;
  ChildEnd end;
  bool wanted = false;
  unsigned restarts = 0;  ///< so far
  bool hung = false;      ///< kExited: the agent killed it, because its loop hung
  std::string reason;     ///< kNotStarted: why; kGivenUp: after what; kHung, and kExited when it hung: how
};

class Keeper {
 public:
  using Clock = std::chrono::steady_clock;

  Keeper(std::vector<PlannedService> services, KeeperOptions options);

  /// Starts what is due, reaps what has ended, kills what hangs. That a service exits is told as soon as it is sure; it
  /// is started again only when nothing is left of it.
  [[nodiscard]] std::vector<Incident> turn(Clock::time_point now);
  /// No more restarts; asks all to end.
  void ask_to_end();
  void kill_all();

  /// Readable when turn() has something to reap, or to tell of a start or an end.
  void append_descriptors(std::vector<pollfd>& descriptors) const;
  /// When the next restart is due.
  [[nodiscard]] std::optional<Clock::time_point> next_start() const;
  [[nodiscard]] bool all_ended() const;
  /// "planner-arm1 was given up after 10 restarts in a row, and is tried again every 60 s (2 times so far)", until it
  /// has lived long enough again.
  [[nodiscard]] std::string complaint() const;
  /// True when there is nothing to complain of.
  [[nodiscard]] bool all_well() const;

 private:
  struct Kept {
    PlannedService service;
    RestartPolicy policy;
    std::optional<ChildProcess> child{};
    std::optional<Clock::time_point> start_at{};
    Clock::time_point started{};
    std::optional<Clock::time_point> began{};  // when it first told that it lives
    Clock::time_point heard{};                 // when it last did, or was started, or we were away ourselves
    std::optional<std::string> hung{};         // how, and was killed; empty: it did not
    bool starting = false;                     // its program is being read
    bool told_end = false;                     // that it ends, which may take a while
    unsigned starts = 0;
    bool given_up = false;
    unsigned retries = 0;                  // since then
    std::optional<std::string> failure{};  // why it could not be started the last time; empty: it could
  };
  void start(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents);
  void settle(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents);
  void not_started(Kept& kept, const std::string& why, Clock::time_point now, std::vector<Incident>& incidents);
  void reap(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents);
  void tell_end(Kept& kept, const ChildEnd& end, std::vector<Incident>& incidents) const;
  void watch(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents);
  void plan_restart(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents);
  void forgive(Kept& kept, Clock::time_point now) const;
  [[nodiscard]] std::chrono::nanoseconds lived(const Kept& kept, Clock::time_point now) const;
  [[nodiscard]] Incident incident(const Kept& kept, Incident::Kind kind) const;

  KeeperOptions options_;
  Reaper reaper_;
  std::vector<Kept> kept_;
  Clock::time_point watched_{};  // the last time that signs of life were looked for
  bool ending_ = false;
};

}  // namespace hecaton::services
