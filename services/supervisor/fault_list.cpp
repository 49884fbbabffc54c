#include "services/supervisor/fault_list.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace hecaton::services {

void FaultList::begin_life(std::uint64_t life) {
  life_ = life;
  const auto enter = [life](FaultRecord& record) { record.life = record.life == 0 ? life : record.life; };
  for (auto& [cause, record] : open_) enter(record);
  for (FaultRecord& record : over_) enter(record);
  for (FaultRecord& record : recalled_) enter(record);
  for (FaultRecord& record : changes_) enter(record);
}

void FaultList::recall(FaultHistory history) {
  open_ = std::move(history.open);
  over_ = std::move(history.over);
  recalled_.assign(over_.rbegin(), over_.rend());
  changes_ = open();
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

FaultRecord* FaultList::find(const FaultRecord& same) {
  const auto is_it = [&](const FaultRecord& one) { return one.life == same.life && one.number == same.number; };
  const auto open = std::find_if(open_.begin(), open_.end(), [&](const auto& entry) { return is_it(entry.second); });
  if (open != open_.end()) return &open->second;
  const auto over = std::find_if(over_.begin(), over_.end(), is_it);
  return over == over_.end() ? nullptr : &*over;
}

void FaultList::explain(FaultRecord& ours, const FaultRecord& better) {
  if (better.kind < ours.kind || (better.kind == ours.kind && better.severity <= ours.severity)) return;
  ours.kind = better.kind;
  ours.severity = std::max(ours.severity, better.severity);
  ours.subject = better.subject;
  ours.seen = better.seen;
  changes_.push_back(ours);
}

void FaultList::adopt(const std::string& cause, FaultRecord record, std::chrono::nanoseconds now) {
  if (FaultRecord* ours = find(record)) return explain(*ours, record);
  // Told and forgotten at once, it would be news to another leader, which would tell it in turn, and so on.
  const bool too_old = record.cleared && over_.size() >= kRemembered && *record.cleared <= *over_.back().cleared;
  if (too_old) return;
  const auto open = open_.find(cause);
  if (!record.cleared && open == open_.end()) {
    changes_.push_back(open_.emplace(cause, std::move(record)).first->second);
    return;
  }
  if (!record.cleared) {  // both saw the same thing, and one record of it is enough from now on
    explain(open->second, record);
    record.cleared = now;
  }
  changes_.push_back(record);
  const auto older = [&](const FaultRecord& one) { return one.cleared <= record.cleared; };
  const auto place = std::find_if(over_.begin(), over_.end(), older);
  over_.insert(place, std::move(record));
  trim();
}

void FaultList::trim() {
  if (over_.size() > kRemembered) over_.pop_back();
}

bool FaultList::knows(msg::CauseKind kind) const {
  const auto same = [kind](const FaultRecord& record) { return record.kind == kind; };
  return std::any_of(over_.begin(), over_.end(), same) ||
         std::any_of(open_.begin(), open_.end(), [&](const auto& entry) { return same(entry.second); });
}

bool FaultList::knows(const FaultSight& sight, std::chrono::nanoseconds since) const {
  const auto same = [&](const FaultRecord& record) {
    return record.kind == sight.kind && record.seen == sight.seen && record.since >= since;
  };
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
  trim();
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

std::vector<FaultRecord> FaultList::take_recalled() {
  return std::exchange(recalled_, {});
}

std::vector<FaultRecord> FaultList::take_changes() {
  return std::exchange(changes_, {});
}

}  // namespace hecaton::services
