#include "services/supervisor/detection/liveness.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::services {
namespace {

/// After a long stall an observer hears all senders again only after a moment (24 ms measured).
constexpr Time kCatchingUp = std::chrono::milliseconds(100);
/// Less than this part of a lost sample is no evidence.
constexpr double kNegligible = 0.1;

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
  entry.must_recover = entry.must_recover || entry.heard;
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
    const bool suspected = entry.presence == Presence::kSuspected || entry.presence == Presence::kLost;
    const bool may_allow = !entry.allowed_until || now - *entry.allowed_until > 2 * limits(entry).silence;
    if (stalled && entry.heard && !suspected && may_allow) entry.allowed_until = now + catching_up;
    entry.presence = judged(entry);
  }
}

Presence Liveness::judged(Entry& entry) const {
  const Time silent = silence(entry);
  const LivenessLimits limit = limits(entry);
  if (!entry.heard) {
    if (silent <= entry.limits.grace) return Presence::kWaiting;
    entry.must_recover = true;
    return Presence::kMissing;
  }
  if (silent > limit.silence) {
    entry.must_recover = true;
    return silent > limit.lost || entry.presence == Presence::kLost ? Presence::kLost : Presence::kSuspected;
  }
  if (entry.must_recover && entry.last - entry.steady_since < entry.limits.recovery) return Presence::kReturning;
  entry.must_recover = false;
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
  return clock_.now() - (entry.allowed_until ? std::max(begin, *entry.allowed_until) : begin);
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

void PacketLossEstimator::expect(const std::string& sender, const std::string& host) {
  senders_[sender].path = host == own_ ? nullptr : &hosts_[host];
}

void PacketLossEstimator::arrived(std::string_view sender, std::int64_t process, std::uint64_t number) {
  const auto found = senders_.find(sender);
  if (found == senders_.end() || !found->second.path || number == 0) return;
  Sender& from = found->second;
  const bool goes_on = from.process == process && number > from.number;
  const std::uint64_t missing = goes_on ? number - from.number - 1 : 0;
  from.process = process;
  from.number = number;
  // More in a row are no losses: the sender or the observer was away.
  const bool believable = missing <= static_cast<std::uint64_t>(longest_gap(kMaxLossRate));
  const double lost = believable ? static_cast<double>(missing) : 0.0;
  from.path->count(clock_.now(), lost);
  all_.count(clock_.now(), lost);
}

double PacketLossEstimator::lost(std::string_view host, const Overdue& overdue) const {
  const auto path = hosts_.find(host);
  if (path == hosts_.end()) return 0.0;
  const Time now = clock_.now();
  return std::min(kMaxLossRate, std::max(path->second.loss_rate(now, overdue.host), all_.loss_rate(now, overdue.all)));
}

int PacketLossEstimator::longest_gap(double lost) {
  return lost <= 0.0 ? 0 : static_cast<int>(std::ceil(std::log(kChanceLimit) / std::log(lost)));
}

void PacketLossEstimator::DecayingCount::count(Time now, double lost) {
  const double remaining = this->remaining(now);
  received_ = received_ * remaining + 1.0;
  lost_ = lost_ * remaining + lost;
  at_ = now;
}

double PacketLossEstimator::DecayingCount::loss_rate(Time now, int overdue) const {
  const double remaining = this->remaining(now);
  const double lost = lost_ * remaining + overdue;
  return lost < kNegligible ? 0.0 : lost / (received_ * remaining + lost);
}

double PacketLossEstimator::DecayingCount::remaining(Time now) const {
  if (now == at_) return 1.0;  // mostly: a turn's samples come together
  return std::exp(-std::chrono::duration<double>(now - at_) / std::chrono::duration<double>(time_constant_));
}

void PacketLossEstimator::Path::count(Time now, double lost) {
  fast.count(now, lost);
  slow.count(now, lost);
}

double PacketLossEstimator::Path::loss_rate(Time now, int overdue) const {
  return std::max(fast.loss_rate(now, overdue), slow.loss_rate(now, overdue));
}

}  // namespace hecaton::services
