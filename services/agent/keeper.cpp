#include "services/agent/keeper.hpp"

#include <algorithm>
#include <csignal>
#include <stdexcept>
#include <utility>

namespace hecaton::services {

namespace {

/// Signs of life are looked for this often in the time that a loop may be silent.
constexpr int kLooks = 20;

/// What was done about a service, to follow its name.
std::string given_up(const RestartLimits& limits, unsigned retries) {
  if (limits.attempts == 0) return "ended and is not restarted";
  std::string text = "was given up after " + std::to_string(limits.attempts) + " restarts in a row";
  if (limits.retry.count() == 0) return text;
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(limits.retry).count();
  text += ", and is tried again every " + std::to_string(seconds) + " s";
  if (retries > 0) text += " (" + std::to_string(retries) + (retries == 1 ? " time" : " times") + " so far)";
  return text;
}

}  // namespace

Keeper::Keeper(std::vector<PlannedService> services, KeeperOptions options) : options_(std::move(options)) {
  kept_.reserve(services.size());
  for (PlannedService& service : services) {
    kept_.push_back({std::move(service), RestartPolicy(options_.restart), {}, Clock::time_point{}});
  }
}

std::vector<Incident> Keeper::turn(Clock::time_point now) {
  std::vector<Incident> incidents;
  const bool watches = options_.watchdog.count() > 0 && !ending_ && now - watched_ >= options_.watchdog / kLooks;
  for (Kept& kept : kept_) {
    settle(kept, now, incidents);
    reap(kept, now, incidents);
    if (kept.start_at && *kept.start_at <= now) start(kept, now, incidents);
    if (watches) watch(kept, now, incidents);
    forgive(kept, now);
  }
  if (watches) watched_ = now;
  return incidents;
}

// Who was stopped itself knows nothing of the others for that time.
void Keeper::watch(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents) {
  if (!kept.child || kept.told_end || kept.hung) return;
  const bool was_away = now - watched_ >= 2 * options_.watchdog / kLooks;
  const bool told = kept.child->told_alive();
  if (told && !kept.began) kept.began = now;
  if (told || was_away) kept.heard = now;
  const auto limit = kept.began ? options_.watchdog : options_.start_limit;
  if (limit.count() == 0 || now - kept.heard < limit) return;
  const auto silence = std::chrono::duration_cast<std::chrono::milliseconds>(now - kept.heard);
  kept.hung = (kept.began ? "its loop was silent for " : "its loop did not begin within ") +
              std::to_string(silence.count()) + " ms";
  incidents.push_back(incident(kept, Incident::Kind::kHung));
  incidents.back().reason = *kept.hung;
  kept.child->signal(SIGKILL);
}

// Only a loop that turns is a life: else who always hangs in its start would be forgiven for how long that took.
std::chrono::nanoseconds Keeper::lived(const Kept& kept, Clock::time_point now) const {
  if (options_.watchdog.count() == 0) return now - kept.started;
  return kept.began ? now - *kept.began : std::chrono::nanoseconds(0);
}

void Keeper::forgive(Kept& kept, Clock::time_point now) const {
  if (!kept.given_up || !kept.child || kept.starting || lived(kept, now) < options_.restart.steady) return;
  kept.given_up = false;
  kept.retries = 0;
}

void Keeper::start(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents) {
  kept.start_at.reset();
  kept.started = now;
  kept.began.reset();
  kept.heard = now;
  kept.hung.reset();
  kept.told_end = false;
  if (kept.given_up) ++kept.retries;
  ChildCommand command{options_.programs / kept.service.program, kept.service.arguments, {}};
  command.tells_alive = options_.watchdog.count() > 0;
  command.tells_end = options_.life_lines;
  if (!options_.logs.empty()) command.log = options_.logs / (kept.service.name + ".log");
  try {
    kept.child.emplace(command);
    kept.starting = true;
  } catch (const std::runtime_error& error) {
    not_started(kept, error.what(), now, incidents);
  }
}

void Keeper::settle(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents) {
  if (!kept.starting) return;
  const auto error = kept.child->poll_start();
  if (!error) return;
  kept.starting = false;
  if (*error != 0) {
    reaper_.take(kept.child->let_go());  // it is about to end
    kept.child.reset();
    not_started(kept, start_failure(options_.programs / kept.service.program, *error), now, incidents);
    return;
  }
  ++kept.starts;
  kept.failure.reset();
  incidents.push_back(incident(kept, Incident::Kind::kStarted));
}

void Keeper::not_started(Kept& kept, const std::string& why, Clock::time_point now, std::vector<Incident>& incidents) {
  incidents.push_back(incident(kept, Incident::Kind::kNotStarted));
  kept.failure = why;
  incidents.back().reason = why;
  if (!ending_) plan_restart(kept, now, incidents);
}

void Keeper::reap(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents) {
  if (!kept.child || kept.starting) return;
  if (const auto doom = kept.child->poll_doom()) tell_end(kept, *doom, incidents);
  const auto end = kept.child->poll_end();
  if (!end) return;
  if (!kept.told_end) tell_end(kept, *end, incidents);
  reaper_.take(kept.child->let_go());
  kept.child.reset();
  if (!ending_) plan_restart(kept, now, incidents);
}

void Keeper::tell_end(Kept& kept, const ChildEnd& end, std::vector<Incident>& incidents) const {
  kept.told_end = true;
  incidents.push_back(incident(kept, Incident::Kind::kExited));
  incidents.back().end = end;
  if (!kept.hung || end.signal_number != SIGKILL) return;  // else it ended by itself at last
  incidents.back().hung = true;
  incidents.back().reason = *kept.hung;
}

void Keeper::plan_restart(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents) {
  if (const auto delay = kept.policy.died(lived(kept, now))) {
    kept.start_at = now + *delay;
    return;
  }
  kept.given_up = true;
  if (options_.restart.attempts > 0 && options_.restart.retry.count() > 0) kept.start_at = now + options_.restart.retry;
  incidents.push_back(incident(kept, Incident::Kind::kGivenUp));
  incidents.back().reason = complaint();
}

Incident Keeper::incident(const Kept& kept, Incident::Kind kind) const {
  Incident incident;
  incident.kind = kind;
  incident.service = &kept.service;
  incident.pid = kept.child ? kept.child->pid() : 0;
  incident.wanted = ending_;
  incident.restarts = kept.starts > 0 ? kept.starts - 1 : 0;
  return incident;
}

void Keeper::ask_to_end() {
  ending_ = true;
  for (Kept& kept : kept_) {
    kept.start_at.reset();
    if (kept.child) kept.child->signal(SIGTERM);
  }
}

void Keeper::kill_all() {
  for (Kept& kept : kept_) {
    if (kept.child) kept.child->signal(SIGKILL);
  }
}

void Keeper::append_descriptors(std::vector<pollfd>& descriptors) const {
  for (const Kept& kept : kept_) {
    if (!kept.child) continue;
    descriptors.push_back({kept.starting ? kept.child->start_fd() : kept.child->fd(), POLLIN, 0});
    if (!kept.starting && kept.child->life_fd() >= 0) descriptors.push_back({kept.child->life_fd(), POLLIN, 0});
  }
}

std::optional<Keeper::Clock::time_point> Keeper::next_start() const {
  std::optional<Clock::time_point> next;
  for (const Kept& kept : kept_) {
    if (kept.start_at && (!next || *kept.start_at < *next)) next = kept.start_at;
  }
  return next;
}

bool Keeper::all_ended() const {
  return std::none_of(kept_.begin(), kept_.end(), [](const Kept& kept) { return kept.child.has_value(); });
}

bool Keeper::all_well() const {
  return std::none_of(kept_.begin(), kept_.end(), [](const Kept& kept) { return kept.given_up || kept.failure; });
}

std::string Keeper::complaint() const {
  std::string text;
  for (const Kept& kept : kept_) {
    if (!kept.given_up && !kept.failure) continue;
    text += (text.empty() ? "" : "; ") + kept.service.name;
    if (kept.given_up) text += " " + given_up(options_.restart, kept.retries);
    if (kept.failure) text += ": " + *kept.failure;
  }
  return text;
}

}  // namespace hecaton::services
