#include "services/agent/keeper.hpp"

#include <algorithm>
#include <csignal>
#include <stdexcept>
#include <utility>

namespace hecaton::services {

namespace {

/// Signs of life are looked for this often in the time that a loop may be silent.
constexpr int kLooks = 20;

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
  }
  if (watches) watched_ = now;
  return incidents;
}

// Who was stopped itself knows nothing of the others for that time.
void Keeper::watch(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents) {
  if (!kept.child) return;
  const bool was_away = now - watched_ >= 2 * options_.watchdog / kLooks;
  if (kept.child->told_alive() || (kept.alive_at && was_away)) kept.alive_at = now;
  if (!kept.alive_at || now - *kept.alive_at < options_.watchdog) return;
  incidents.push_back(incident(kept, Incident::Kind::kHung));
  const auto silence = std::chrono::duration_cast<std::chrono::milliseconds>(now - *kept.alive_at);
  incidents.back().reason = "its loop was silent for " + std::to_string(silence.count()) + " ms";
  kept.child->signal(SIGKILL);
  kept.alive_at.reset();
}

void Keeper::start(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents) {
  kept.start_at.reset();
  kept.started = now;
  kept.alive_at.reset();
  ChildCommand command{
      options_.programs / kept.service.program, kept.service.arguments, {}, options_.watchdog.count() > 0};
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
    kept.child.reset();
    not_started(kept, start_failure(options_.programs / kept.service.program, *error), now, incidents);
    return;
  }
  ++kept.starts;
  kept.failure.clear();
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
  const auto end = kept.child->poll_end();
  if (!end) return;
  incidents.push_back(incident(kept, Incident::Kind::kExited));
  incidents.back().end = *end;
  kept.child.reset();
  if (!ending_) plan_restart(kept, now, incidents);
}

void Keeper::plan_restart(Kept& kept, Clock::time_point now, std::vector<Incident>& incidents) {
  if (const auto delay = kept.policy.died(now - kept.started)) {
    kept.start_at = now + *delay;
    return;
  }
  kept.given_up = true;
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
    if (kept.child) descriptors.push_back({kept.starting ? kept.child->start_fd() : kept.child->fd(), POLLIN, 0});
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

std::string Keeper::complaint() const {
  std::string text;
  for (const Kept& kept : kept_) {
    if (!kept.given_up && kept.failure.empty()) continue;
    text += (text.empty() ? "" : "; ") + kept.service.name;
    if (!kept.failure.empty()) {
      text += ": " + kept.failure;
      continue;
    }
    text += options_.restart.attempts == 0
                ? " ended and is not restarted"
                : " was given up after " + std::to_string(options_.restart.attempts) + " restarts in a row";
  }
  return text;
}

}  // namespace hecaton::services
