#include "services/supervisor/detection/liveness.hpp"

#include <algorithm>

namespace hecaton::services {
namespace {

/// After a long stall an observer hears all senders again only after a moment (up to 24 ms).
constexpr Time kCatchingUp = std::chrono::milliseconds(100);

}  // namespace

void Liveness::expect(const std::string& name, const LivenessLimits& limits) {
  Entry entry;
  entry.limits = limits;
  entry.since = clock_.now();
  entries_.insert_or_assign(name, entry);
}

void Liveness::restarted(std::string_view name) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) return;
  Entry& entry = found->second;
  entry.must_prove = entry.must_prove || entry.heard;
  entry.presence = Presence::kWaiting;
  entry.heard = false;
  entry.since = clock_.now();
}

void Liveness::heard(std::string_view name, Time at) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) return;
  Entry& entry = found->second;
  const Time when = clock_.at(at);
  if (entry.heard && when <= entry.last) return;
  if (!entry.heard || when - entry.last > limits(entry).silence) entry.steady_since = when;
  entry.heard = true;
  entry.last = when;
}

void Liveness::allow(std::string_view name, Time silence) {
  const auto found = entries_.find(name);
  if (found != entries_.end()) found->second.allowed = silence;
}

void Liveness::judge(bool stalled) {
  const Time catching_up = clock_.last_stall() > StallCompensatedClock::kLongStall ? kCatchingUp : Time(0);
  for (auto& [name, entry] : entries_) {
    const Time now = clock_.now();
    const bool accused = entry.presence == Presence::kSuspected || entry.presence == Presence::kLost;
    const bool pardonable = !entry.pardoned || now - *entry.pardoned > 2 * limits(entry).silence;
    if (stalled && entry.heard && !accused && pardonable) entry.pardoned = now + catching_up;
    entry.presence = judged(entry);
  }
}

Presence Liveness::judged(Entry& entry) const {
  const Time silent = silence(entry);
  const LivenessLimits limit = limits(entry);
  if (!entry.heard) {
    if (silent <= entry.limits.grace) return Presence::kWaiting;
    entry.must_prove = true;
    return Presence::kMissing;
  }
  if (silent > limit.silence) {
    entry.must_prove = true;
    return silent > limit.lost || entry.presence == Presence::kLost ? Presence::kLost : Presence::kSuspected;
  }
  if (entry.must_prove && entry.last - entry.steady_since < entry.limits.recovery) return Presence::kReturning;
  entry.must_prove = false;
  return Presence::kAlive;
}

const Liveness::Entry* Liveness::find(std::string_view name) const {
  const auto found = entries_.find(name);
  return found == entries_.end() ? nullptr : &found->second;
}

Presence Liveness::presence(std::string_view name) const {
  const Entry* entry = find(name);
  return entry ? entry->presence : Presence::kWaiting;
}

LivenessLimits Liveness::limits(const Entry& entry) {
  LivenessLimits limits = entry.limits;
  limits.silence = std::max(limits.silence, entry.allowed);
  limits.lost = std::max(limits.lost, entry.allowed);
  return limits;
}

LivenessLimits Liveness::limits(std::string_view name) const {
  const Entry* entry = find(name);
  return entry ? limits(*entry) : LivenessLimits{};
}

Time Liveness::silence(const Entry& entry) const {
  const Time begin = entry.heard ? entry.last : entry.since;
  return clock_.now() - (entry.pardoned ? std::max(begin, *entry.pardoned) : begin);
}

Time Liveness::silence(std::string_view name) const {
  const Entry* entry = find(name);
  return entry ? silence(*entry) : Time(0);
}

std::optional<Time> Liveness::last_heard(std::string_view name) const {
  const Entry* entry = find(name);
  if (!entry || !entry->heard) return std::nullopt;
  return entry->last;
}

std::optional<Time> Liveness::steady_since(std::string_view name) const {
  const Entry* entry = find(name);
  if (!entry || !entry->heard) return std::nullopt;
  return entry->steady_since;
}

}  // namespace hecaton::services
