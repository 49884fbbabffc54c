#include "services/agent/process_manager.hpp"

#include <csignal>
#include <stdexcept>
#include <utility>

namespace hecaton::services {

namespace {

/// Checks of heartbeats within the time that a loop may be silent.
constexpr int kChecks = 20;
/// Between checks of memory. A process cannot fill a machine within it.
constexpr std::chrono::milliseconds kMemoryPeriod{100};
/// Sanitizers map terabytes.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitsData = false;
#else
constexpr bool kLimitsData = true;
#endif

std::string megabytes(std::uint64_t bytes) {
  return std::to_string(bytes / 1'000'000) + " MB";
}

/// Predicate of a sentence whose subject is the service.
std::string given_up_text(const RestartLimits& limits, unsigned retries) {
  if (limits.attempts == 0) return "ended and is not restarted";
  std::string text = "was given up after " + std::to_string(limits.attempts) + " restarts in a row";
  if (limits.retry.count() == 0) return text;
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(limits.retry).count();
  text += ", and is tried again every " + std::to_string(seconds) + " s";
  if (retries > 0) text += " (" + std::to_string(retries) + (retries == 1 ? " time" : " times") + " so far)";
  return text;
}

}  // namespace

ProcessManager::ProcessManager(std::vector<PlannedService> services, ProcessManagerOptions options)
    : options_(std::move(options)) {
  processes_.reserve(services.size());
  for (PlannedService& service : services) {
    processes_.push_back({std::move(service), RestartPolicy(options_.restart), {}, Clock::time_point{}});
  }
}

std::vector<ProcessEvent> ProcessManager::turn(Clock::time_point now) {
  Events events;
  const bool checks = options_.watchdog.count() > 0 && !ending_ && now - checked_ >= options_.watchdog / kChecks;
  const bool weighs = options_.memory_limit > 0 && !ending_ && now - memory_checked_ >= kMemoryPeriod;
  for (Process& process : processes_) {
    check_start(process, now, events);
    check_exit(process, now, events);
    if (process.start_at && *process.start_at <= now) start(process, now, events);
    if (checks) check_heartbeats(process, now, events);
    if (weighs) check_memory(process, events);
    reset_retries(process, now);
  }
  if (checks) checked_ = now;
  if (weighs) memory_checked_ = now;
  return events;
}

void ProcessManager::check_heartbeats(Process& process, Clock::time_point now, Events& events) {
  if (!process.child || process.exit_reported || process.killed != KillReason::kNone) return;
  const bool was_away = now - checked_ >= 2 * options_.watchdog / kChecks;  // this process was stopped
  const bool has_heartbeat = process.child->take_heartbeats();
  if (has_heartbeat && !process.first_heartbeat) process.first_heartbeat = now;
  if (has_heartbeat || was_away) process.silent_since = now;
  const auto limit = process.first_heartbeat ? options_.watchdog : options_.start_limit;
  if (limit.count() == 0 || now - process.silent_since < limit) return;
  const auto silence = std::chrono::duration_cast<std::chrono::milliseconds>(now - process.silent_since);
  kill(process, KillReason::kHung,
       (process.first_heartbeat ? "its loop was silent for " : "its loop did not begin within ") +
           std::to_string(silence.count()) + " ms",
       events);
}

void ProcessManager::check_memory(Process& process, Events& events) const {
  if (!process.child || process.starting || process.exit_reported || process.killed != KillReason::kNone) return;
  const std::uint64_t memory = process.child->memory();
  if (memory <= options_.memory_limit) return;
  // Rounded up, so that it is above the limit in the sentence, too.
  kill(process, KillReason::kTooLarge,
       "it used " + megabytes(memory + 999'999) +
           " of memory, more than supervision.memory_limit = " + megabytes(options_.memory_limit) + " allows",
       events);
}

void ProcessManager::kill(Process& process, KillReason reason, std::string text, Events& events) const {
  process.killed = reason;
  process.kill_text = std::move(text);
  events.push_back(event(process, ProcessEvent::Kind::kKilled));
  events.back().killed = reason;
  events.back().reason = process.kill_text;
  process.child->signal(SIGKILL);
}

// Uptime begins with the first heartbeat. Otherwise the time of a hanging start would count as steady operation.
std::chrono::nanoseconds ProcessManager::uptime(const Process& process, Clock::time_point now) const {
  if (options_.watchdog.count() == 0) return now - process.started;
  return process.first_heartbeat ? now - *process.first_heartbeat : std::chrono::nanoseconds(0);
}

void ProcessManager::reset_retries(Process& process, Clock::time_point now) const {
  if (!process.given_up || !process.child || process.starting || uptime(process, now) < options_.restart.steady) return;
  process.given_up = false;
  process.retries = 0;
}

void ProcessManager::start(Process& process, Clock::time_point now, Events& events) {
  process.start_at.reset();
  process.started = now;
  process.first_heartbeat.reset();
  process.silent_since = now;
  process.killed = KillReason::kNone;
  process.exit_reported = false;
  if (process.given_up) ++process.retries;
  ChildCommand command{options_.programs / process.service.program, process.service.arguments, {}};
  command.sends_heartbeats = options_.watchdog.count() > 0;
  command.notifies_exit = options_.exit_notifiers;
  if (kLimitsData && options_.memory_limit > 0) command.most_data = options_.memory_limit + kMemoryMargin;
  if (!options_.logs.empty()) command.log = options_.logs / (process.service.name + ".log");
  try {
    process.child.emplace(command);
    process.starting = true;
  } catch (const std::runtime_error& error) {
    report_start_failure(process, error.what(), now, events);
  }
}

void ProcessManager::check_start(Process& process, Clock::time_point now, Events& events) {
  if (!process.starting) return;
  const auto error = process.child->poll_start();
  if (!error) return;
  process.starting = false;
  if (*error != 0) {
    reaper_.take(process.child->release());  // it is about to end
    process.child.reset();
    report_start_failure(process, start_failure(options_.programs / process.service.program, *error), now, events);
    return;
  }
  ++process.starts;
  process.start_failure.reset();
  events.push_back(event(process, ProcessEvent::Kind::kStarted));
}

void ProcessManager::report_start_failure(Process& process, const std::string& why, Clock::time_point now,
                                          Events& events) {
  events.push_back(event(process, ProcessEvent::Kind::kNotStarted));
  process.start_failure = why;
  events.back().reason = why;
  if (!ending_) plan_restart(process, now, events);
}

void ProcessManager::check_exit(Process& process, Clock::time_point now, Events& events) {
  if (!process.child || process.starting) return;
  if (const auto end = process.child->poll_announced_end()) report_exit(process, *end, events);
  const auto end = process.child->poll_end();
  if (!end) return;
  if (!process.exit_reported) report_exit(process, *end, events);
  reaper_.take(process.child->release());
  process.child.reset();
  if (!ending_) plan_restart(process, now, events);
}

void ProcessManager::report_exit(Process& process, const ChildEnd& end, Events& events) const {
  process.exit_reported = true;
  events.push_back(event(process, ProcessEvent::Kind::kExited));
  events.back().end = end;
  if (process.killed == KillReason::kNone || end.signal_number != SIGKILL) return;  // it ended by itself
  events.back().killed = process.killed;
  events.back().reason = process.kill_text;
}

void ProcessManager::plan_restart(Process& process, Clock::time_point now, Events& events) {
  if (const auto delay = process.policy.delay_after(uptime(process, now))) {
    process.start_at = now + *delay;
    return;
  }
  process.given_up = true;
  if (options_.restart.attempts > 0 && options_.restart.retry.count() > 0) {
    process.start_at = now + options_.restart.retry;
  }
  events.push_back(event(process, ProcessEvent::Kind::kGivenUp));
  events.back().reason = problem();
}

ProcessEvent ProcessManager::event(const Process& process, ProcessEvent::Kind kind) const {
  ProcessEvent event;
  event.kind = kind;
  event.service = &process.service;
  event.pid = process.child ? process.child->pid() : 0;
  event.wanted = ending_;
  event.restarts = process.starts > 0 ? process.starts - 1 : 0;
  return event;
}

void ProcessManager::terminate_all() {
  ending_ = true;
  for (Process& process : processes_) {
    process.start_at.reset();
    if (process.child) process.child->signal(SIGTERM);
  }
}

void ProcessManager::kill_all() {
  for (Process& process : processes_) {
    if (process.child) process.child->signal(SIGKILL);
  }
}

void ProcessManager::append_descriptors(std::vector<pollfd>& descriptors) const {
  for (const Process& process : processes_) {
    if (!process.child) continue;
    descriptors.push_back({process.starting ? process.child->start_fd() : process.child->fd(), POLLIN, 0});
    if (!process.starting && process.child->exit_fd() >= 0)
      descriptors.push_back({process.child->exit_fd(), POLLIN, 0});
  }
}

std::optional<ProcessManager::Clock::time_point> ProcessManager::next_start() const {
  std::optional<Clock::time_point> next;
  for (const Process& process : processes_) {
    if (process.start_at && (!next || *process.start_at < *next)) next = process.start_at;
  }
  return next;
}

bool ProcessManager::all_ended() const {
  return std::none_of(processes_.begin(), processes_.end(),
                      [](const Process& process) { return process.child.has_value(); });
}

bool ProcessManager::healthy() const {
  return std::none_of(processes_.begin(), processes_.end(),
                      [](const Process& process) { return process.given_up || process.start_failure; });
}

std::string ProcessManager::problem() const {
  std::string text;
  for (const Process& process : processes_) {
    if (!process.given_up && !process.start_failure) continue;
    text += (text.empty() ? "" : "; ") + process.service.name;
    if (process.given_up) text += " " + given_up_text(options_.restart, process.retries);
    if (process.start_failure) text += ": " + *process.start_failure;
  }
  return text;
}

}  // namespace hecaton::services
