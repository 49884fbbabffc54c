#include "services/supervisor/detection/host_monitor.hpp"

#include <algorithm>

namespace hecaton::services {
namespace {

/// Maintains since when a condition holds without a gap.
void keep_since(std::optional<Time>& since, bool holds, Time now) {
  if (!holds) {
    since.reset();
  } else if (!since) {
    since = now;
  }
}

}  // namespace

ReachabilityMatrix::ReachabilityMatrix(std::vector<std::string> hosts, Time link_deadline, Time absence)
    : link_deadline_(link_deadline), absence_(absence) {
  for (std::string& host : hosts) {
    rows_.push_back({std::move(host)});
    rows_.back().ages.resize(hosts.size());
    rows_.back().found.resize(hosts.size());
  }
}

std::optional<HostIndex> ReachabilityMatrix::index(std::string_view host) const {
  const auto found = std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.host == host; });
  if (found == rows_.end()) return std::nullopt;
  return static_cast<HostIndex>(found - rows_.begin());
}

void ReachabilityMatrix::update(HostIndex observer, const std::vector<HostAge>& ages, Time at) {
  Row& row = rows_[observer];
  if (row.at && at < *row.at) return;
  if (!row.at || at - *row.at >= link_deadline_) row.steady_since = at;
  if (!row.at || at - *row.at >= absence_) {
    row.returned = at;
    row.found.assign(rows_.size(), false);
  }
  row.at = at;
  row.ages.assign(rows_.size(), std::nullopt);
  for (const HostAge& heard : ages) {
    const auto subject = index(heard.host);
    if (!subject) continue;
    if (heard.age < link_deadline_) row.found[*subject] = true;
    if (row.found[*subject]) row.ages[*subject] = heard.age;
  }
}

bool ReachabilityMatrix::fresh(HostIndex observer, Time now) const {
  const Row& row = rows_[observer];
  return row.at && now - *row.at < link_deadline_;
}

bool ReachabilityMatrix::steady(HostIndex observer, Time now) const {
  return fresh(observer, now) && now - rows_[observer].steady_since >= link_deadline_;
}

std::optional<Time> ReachabilityMatrix::age(HostIndex observer, HostIndex subject, Time now) const {
  if (!fresh(observer, now) || !rows_[observer].ages[subject]) return std::nullopt;
  return *rows_[observer].ages[subject] + (now - *rows_[observer].at);
}

bool ReachabilityMatrix::hears(HostIndex observer, HostIndex subject, Time now) const {
  const auto age = this->age(observer, subject, now);
  return age && *age < link_deadline_;
}

HostMonitor::HostMonitor(std::vector<std::string> hosts, const std::string& own, const HostLimits& limits,
                         const StallCompensatedClock& clock)
    : limits_(limits),
      clock_(clock),
      matrix_(std::move(hosts), limits.link_deadline, limits.sure_return),
      own_(matrix_.index(own)),
      hosts_(matrix_.size()) {}

void HostMonitor::heard(HostIndex host, Time at, bool from_agent) {
  Host& known = hosts_[host];
  known.has_agent = known.has_agent || from_agent;
  if (known.heard && at <= *known.heard) return;
  if (!known.heard || at - *known.heard >= limits_.pause) known.returned = at;
  if (!known.heard || at - *known.heard >= limits_.link_deadline) known.steady_since = at;
  known.heard = at;
}

void HostMonitor::row(HostIndex host, const std::vector<HostAge>& ages, Time at) {
  matrix_.update(host, ages, at);
  heard(host, at, true);
}

void HostMonitor::judge(Time stall) {
  note_stall(stall);
  note_directions();
  judge_own();
  for (HostIndex host = 0; host < hosts_.size(); ++host) {
    if (!is_other(host) || isolated()) continue;
    judge_deaf(host);
    judge_silent(host);
  }
  judge_links();
  note_absences();
}

// After a long stall the supervisor has to hear every host again first. After a stall longer than a sure return its
// peers may have dropped it.
void HostMonitor::note_stall(Time stall) {
  if (stall <= StallCompensatedClock::kLongStall) return;
  unsettled_ = now();
  for (HostIndex host = 0; host < hosts_.size(); ++host) {
    hosts_[host].returned = hosts_[host].steady_since = now();
    if (stall > limits_.sure_return && host != own_) hosts_[host].away = now();
  }
}

void HostMonitor::note_directions() {
  const auto hears_any = [&](HostIndex host) {
    for (HostIndex other = 0; other < hosts_.size(); ++other) {
      if (other != host && matrix_.hears(host, other, now())) return true;
    }
    return false;
  };
  for (HostIndex host = 0; host < hosts_.size(); ++host) {
    Host& known = hosts_[host];
    keep_since(known.hearing_since, hears_any(host), now());
    // Rows are evidence about agents. Without both agents only steady packets since the isolation prove the return.
    const bool has_rows = own_ && host != own_ && matrix_.fresh(*own_, now()) && matrix_.fresh(host, now());
    const bool steady = known.heard && known.steady_since >= isolated_at_.value_or(Time(0)) &&
                        *known.heard - known.steady_since >= limits_.sure_return;
    keep_since(known.mutual_since, is_live(host) && (has_rows ? matrix_.hears(host, *own_, now()) : !own_ || steady),
               now());
  }
}

// Rule 5, self. The supervisor's host hears no other host, and several fell silent together. Or several other hosts
// send rows, and none of them has heard this host for a lease. Then the supervisor judges no other host.
void HostMonitor::judge_own() {
  if (!own_) return;
  const auto [together, silence] = silent_together();
  const bool deaf = together >= 2 && silence > limits_.lease;
  int observers = 0;
  bool is_heard = false;
  for (HostIndex host = 0; host < hosts_.size(); ++host) {
    const auto age = is_other(host) ? unheard_for(*own_, host) : std::nullopt;
    if (!age || now() - *matrix_.arrival(host) > limits_.recent_row) continue;
    ++observers;
    is_heard = is_heard || *age <= limits_.lease;
  }
  const bool mute = observers >= 2 && !is_heard;
  HostState& state = hosts_[*own_].state;
  if (deaf || mute) {
    state = HostState::kIsolated;
    isolated_at_ = now();
  } else if (state == HostState::kIsolated) {
    for (HostIndex host = 0; host < hosts_.size(); ++host) {
      const auto& mutual = hosts_[host].mutual_since;
      if (is_other(host) && mutual && now() - *mutual >= limits_.recovery) state = HostState::kHeard;
    }
  }
  if (state == HostState::kIsolated) unsettled_ = now();
}

// Rule 4, deaf. A host is heard, but its own row has heard no other host for a lease, although several send. A host
// that has just returned has to discover its peers first.
void HostMonitor::judge_deaf(HostIndex host) {
  Host& known = hosts_[host];
  if (known.state == HostState::kIsolated) {
    const bool hears = known.hearing_since && now() - *known.hearing_since >= limits_.recovery;
    if (is_live(host) && hears) known.state = HostState::kHeard;
    return;
  }
  const bool is_back = is_live(host) && now() - known.steady_since > limits_.lease + limits_.link_deadline;
  if (known.state != HostState::kHeard || !is_back || is_rediscovering(host) || settles()) return;
  int senders = 0;
  for (HostIndex other = 0; other < hosts_.size(); ++other) {
    const bool counts = other != host && !is_rediscovering(other);
    const auto age = counts ? unheard_for(other, host) : std::nullopt;
    if (!age) continue;
    if (*age <= limits_.lease) return;
    ++senders;
  }
  if (senders >= 2) known.state = HostState::kIsolated;
}

// Rule 3, host. The supervisor has not heard a host for a lease, other hosts send rows, and no row has heard it: the
// host is lost. Rule 7, return: it has returned after `recovery` of hearing in both directions.
void HostMonitor::judge_silent(HostIndex host) {
  Host& known = hosts_[host];
  if (known.state == HostState::kLost) {
    if (known.mutual_since && now() - *known.mutual_since >= limits_.recovery) known.state = HostState::kHeard;
    return;
  }
  if (!is_silent(host) || settles() || is_heard_by_others(host, {})) return;
  if (!has_witness(host)) return;  // rules 5 and 6
  bool is_proven = false;          // by a row of an agent that has heard it before
  for (HostIndex other = 0; other < hosts_.size(); ++other) {
    const auto age = other == host || !is_other(other) ? std::nullopt : matrix_.age(other, host, now());
    if (age && *age <= limits_.lease) return;  // heard within the lease
    is_proven = is_proven || age;
  }
  if (is_proven || !is_rediscovering(host)) known.state = HostState::kLost;
}

// Rules 2 and 6, links.
void HostMonitor::judge_links() {
  for (HostIndex subject = 0; subject < hosts_.size(); ++subject) {
    for (HostIndex observer = 0; observer < hosts_.size(); ++observer) {
      if (subject != observer && hosts_[subject].has_agent && hosts_[observer].has_agent) judge_link(subject, observer);
    }
  }
}

// Rule 2, link. `observer` has not heard `subject` for a lease, although another host hears `subject`. `observer` hears
// another host, and the evidence has lasted for a link deadline. Rule 6: without rows of a third host, a lost host, an
// isolated one and a lost link cannot be distinguished. The fault is the link between the two.
void HostMonitor::judge_link(HostIndex subject, HostIndex observer) {
  const auto key = std::minmax(subject, observer);
  const auto found = pairs_.find(key);
  const bool proven = found != pairs_.end() && found->second.proven;
  const bool same = found != pairs_.end() && found->second.link.subject == subject;
  const auto explained = [&](HostIndex host) { return hosts_[host].state != HostState::kHeard; };
  if (explained(subject) || explained(observer)) {
    if (found != pairs_.end() && !isolated()) pairs_.erase(found);
    return;
  }
  if (proven) {
    if (!same) return;
    keep_since(found->second.heard_since, hears_again(subject, observer) && hears_again(observer, subject), now());
    const auto& since = found->second.heard_since;
    if (since && now() - *since >= limits_.recovery) pairs_.erase(found);
    return;
  }
  if (isolated() || settles() || !is_not_heard(subject, observer)) {
    if (same) pairs_.erase(found);
    return;
  }
  Pair& pair = pairs_.try_emplace(key, Pair{{subject, observer, now()}}).first->second;
  const bool waits = observer != own_ || has_witness(subject);
  const bool has_lasted = !waits || now() - pair.link.since >= limits_.link_deadline;
  if (pair.link.subject == subject && has_lasted) pair.proven = true;
}

bool HostMonitor::is_not_heard(HostIndex subject, HostIndex observer) const {
  if (is_rediscovering(subject) || is_rediscovering(observer)) return false;
  const HostIndex far = subject == own_ ? observer : subject;
  const bool only_two = (subject == own_ || observer == own_) && !has_witness(far);
  if (observer == own_ && is_silent(subject)) {
    // The agent of this host hears the subject: only this process has lost it, and discovery will match them again.
    const bool by_itself = matrix_.hears(observer, subject, now()) && *silence(subject) <= limits_.rediscovery;
    return !by_itself && (only_two ? !may_be_isolated() : is_heard_by_others(subject, observer));
  }
  const auto age = unheard_for(subject, observer);
  if (!age || *age <= limits_.lease) return false;
  if (only_two) return true;
  const auto hears_another = [&] {
    for (HostIndex other = 0; other < hosts_.size(); ++other) {
      if (other != subject && other != observer && matrix_.hears(observer, other, now())) return true;
    }
    return false;
  };
  // The observer hears every other host whose rows it receives.
  return hears_another() && (subject != own_ || is_heard_by_others(subject, observer));
}

bool HostMonitor::hears_again(HostIndex subject, HostIndex observer) const {
  if (observer == own_) return is_live(subject);
  if (subject == own_ && !matrix_.fresh(subject, now())) return is_live(observer);  // its agent sends no rows
  return matrix_.hears(observer, subject, now());
}

// Rule 7, return. After an absence of a lease discovery matches the processes of a host again one by one.
void HostMonitor::note_absences() {
  for (HostIndex host = 0; host < hosts_.size(); ++host) {
    if (!is_other(host)) continue;
    const bool lost = isolated() || hosts_[host].state != HostState::kHeard || link_is_lost(host);
    const bool is_examined = own_ && pairs_.contains(std::minmax(host, *own_));
    if (lost || (is_silent(host) && !is_rediscovering(host) && !is_examined)) hosts_[host].away = now();
  }
}

std::vector<HostMonitor::Link> HostMonitor::lost_links() const {
  std::vector<Link> lost;
  for (const auto& [hosts, pair] : pairs_) {
    if (pair.proven) lost.push_back(pair.link);
  }
  return lost;
}

std::optional<Time> HostMonitor::silence(HostIndex host) const {
  if (!hosts_[host].heard) return std::nullopt;
  return now() - *hosts_[host].heard;
}

bool HostMonitor::link_is_lost(HostIndex host) const {
  if (!own_) return false;
  const auto pair = pairs_.find(std::minmax(host, *own_));
  return pair != pairs_.end() && pair->second.proven;
}

std::optional<Time> HostMonitor::away(HostIndex host) const {
  const auto& away = hosts_[host].away;
  return away && now() - *away <= limits_.rediscovery ? away : std::nullopt;
}

bool HostMonitor::hears_most(Time limit) const {
  int all = 0;
  int heard = 0;
  for (HostIndex host = 0; host < hosts_.size(); ++host) {
    if (!hosts_[host].has_agent) continue;
    ++all;
    heard += *silence(host) < limit ? 1 : 0;
  }
  return 2 * heard > all;
}

bool HostMonitor::is_silent(HostIndex host) const {
  const auto silence = this->silence(host);
  return silence && *silence > std::max(limits_.lease, hosts_[host].allowed);
}

bool HostMonitor::is_live(HostIndex host) const {
  const auto silence = this->silence(host);
  return silence && *silence < limits_.link_deadline;
}

std::optional<Time> HostMonitor::unheard_for(HostIndex subject, HostIndex observer) const {
  const auto age = matrix_.age(observer, subject, now());
  if (!age || !matrix_.steady(subject, now())) return std::nullopt;
  const Time returned = matrix_.returned(subject);
  const bool was_heard = now() - *age >= returned || now() - returned > limits_.rediscovery;
  return was_heard ? age : std::nullopt;
}

bool HostMonitor::is_heard_by_others(HostIndex host, std::optional<HostIndex> except) const {
  for (HostIndex other = 0; other < hosts_.size(); ++other) {
    if (other != host && other != except && matrix_.hears(other, host, now())) return true;
  }
  return false;
}

bool HostMonitor::has_witness(HostIndex host) const {
  for (HostIndex other = 0; other < hosts_.size(); ++other) {
    if (other != host && is_other(other) && matrix_.fresh(other, now())) return true;
  }
  return false;
}

bool HostMonitor::may_be_isolated() const {
  const auto [together, silence] = silent_together();
  return together >= 2 && silence >= limits_.link_deadline;
}

bool HostMonitor::is_rediscovering(HostIndex host) const {
  const auto away = this->away(host);
  if (!away) return false;
  const Host& known = hosts_[host];
  return !known.heard || *known.heard - std::max(known.steady_since, *away) < limits_.sure_return;
}

bool HostMonitor::settles() const {
  return unsettled_ && now() - *unsettled_ <= limits_.lease + limits_.link_deadline;
}

std::pair<int, Time> HostMonitor::silent_together() const {
  std::vector<Time> silences;
  for (HostIndex host = 0; host < hosts_.size(); ++host) {
    if (is_other(host)) silences.push_back(*silence(host));
  }
  if (silences.empty()) return {0, Time(0)};
  const Time shortest = *std::min_element(silences.begin(), silences.end());
  const auto with_the_last = [&](Time silence) { return silence <= shortest + limits_.lease; };
  return {static_cast<int>(std::count_if(silences.begin(), silences.end(), with_the_last)), shortest};
}

}  // namespace hecaton::services
