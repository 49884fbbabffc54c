#include "services/supervisor/fault_list.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace hecaton::services {

std::string_view fault_kind_name(FaultKind kind) {
  switch (kind) {
    case FaultKind::kDriverSilent:
      return "driver_silent";
    case FaultKind::kWorldSilent:
      return "world_silent";
    case FaultKind::kNodeMissing:
      return "node_missing";
    case FaultKind::kNodeSilent:
      return "node_silent";
    case FaultKind::kProcessDied:
      return "process_died";
    case FaultKind::kNodeFailed:
      return "node_failed";
    case FaultKind::kAgentLost:
      return "agent_lost";
    case FaultKind::kContact:
      return "contact";
  }
  return "unknown";
}

std::optional<FaultKind> fault_kind(std::string_view name) {
  for (int i = 0; i <= static_cast<int>(FaultKind::kContact); ++i) {
    const auto kind = static_cast<FaultKind>(i);
    if (fault_kind_name(kind) == name) return kind;
  }
  return std::nullopt;
}

void FaultList::recall(FaultHistory history) {
  open_ = std::move(history.open);
  over_ = std::move(history.over);
  changes_.assign(over_.rbegin(), over_.rend());
  for (const FaultRecord& record : open()) changes_.push_back(record);
}

bool FaultList::raise(const std::string& cause, const FaultSight& sight, std::chrono::nanoseconds now) {
  const auto [entry, opened] = open_.try_emplace(cause);
  FaultRecord& record = entry->second;
  if (opened) {
    record.life = life_;
    record.number = ++last_number_;
    record.since = sight.since.value_or(now);
    record.detected_within = sight.detected_within;
  } else if (sight.kind < record.kind || (sight.kind == record.kind && sight.severity <= record.severity)) {
    return false;
  }
  const bool is_new = opened || sight.kind != record.kind;
  record.kind = sight.kind;
  record.severity = opened ? sight.severity : std::max(record.severity, sight.severity);
  record.subject = sight.subject;
  record.seen = sight.seen;
  changes_.push_back(record);
  return is_new;
}

bool FaultList::knows(FaultKind kind) const {
  const auto same = [kind](const FaultRecord& record) { return record.kind == kind; };
  return std::any_of(over_.begin(), over_.end(), same) ||
         std::any_of(open_.begin(), open_.end(), [&](const auto& entry) { return same(entry.second); });
}

bool FaultList::knows(const FaultSight& sight) const {
  const auto same = [&](const FaultRecord& record) { return record.kind == sight.kind && record.seen == sight.seen; };
  return std::any_of(over_.begin(), over_.end(), same) ||
         std::any_of(open_.begin(), open_.end(), [&](const auto& entry) { return same(entry.second); });
}

void FaultList::clear(std::string_view cause, std::chrono::nanoseconds now) {
  const auto entry = open_.find(cause);
  if (entry == open_.end()) return;
  FaultRecord record = std::move(entry->second);
  open_.erase(entry);
  record.cleared = now;
  changes_.push_back(record);
  over_.push_front(std::move(record));
  if (over_.size() > kRemembered) over_.pop_back();
}

const FaultRecord* FaultList::open(std::string_view cause) const {
  const auto entry = open_.find(cause);
  return entry == open_.end() ? nullptr : &entry->second;
}

std::vector<FaultRecord> FaultList::open() const {
  std::vector<FaultRecord> records;
  for (const auto& [cause, record] : open_) records.push_back(record);
  std::sort(records.begin(), records.end(), [](const FaultRecord& a, const FaultRecord& b) {
    return std::tie(a.life, a.number) < std::tie(b.life, b.number);
  });
  return records;
}

std::vector<FaultRecord> FaultList::take_changes() {
  return std::exchange(changes_, {});
}

}  // namespace hecaton::services
