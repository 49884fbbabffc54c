#include "services/supervisor/fault_list.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "services/runtime/node_name.hpp"
#include "services/supervisor/clipped_text.hpp"

namespace hecaton::services {
namespace {

/// Separates a node from the kind of a fault that the node may have beside its other one.
constexpr char kKindSeparator = '#';

}  // namespace

std::string node_fault_key(msg::CauseKind kind, const std::string& node) {
  const bool has_own_key =
      kind == msg::CauseKind::CAUSE_DUPLICATE_NODE || kind == msg::CauseKind::CAUSE_PERSISTENCE_FAILED ||
      kind == msg::CauseKind::CAUSE_CHECKPOINT_LOST || kind == msg::CauseKind::CAUSE_INPUT_REFUSED ||
      kind == msg::CauseKind::CAUSE_SECOND_WRITER || kind == msg::CauseKind::CAUSE_CERTIFICATE_EXPIRES ||
      kind == msg::CauseKind::CAUSE_ARM_STANDS || device_fault(kind).has_value();
  return has_own_key ? node + kKindSeparator + std::string(cause_name(kind)) : node;
}

std::string fault_key(msg::CauseKind kind, const std::string& subject) {
  if (device_fault(kind)) return node_fault_key(kind, driver_node(subject));
  switch (kind) {
    case msg::CauseKind::CAUSE_DRIVER_SILENT:
    case msg::CauseKind::CAUSE_ARM_STANDS:
      return node_fault_key(kind, driver_node(subject));
    case msg::CauseKind::CAUSE_HOST_LOST:
    case msg::CauseKind::CAUSE_HOST_ISOLATED:
      return agent_node(subject);
    case msg::CauseKind::CAUSE_CERTIFICATE_EXPIRES:
      return node_fault_key(kind, agent_node(subject));
    case msg::CauseKind::CAUSE_LINK_LOST:
      return "link " + subject;
    default:
      return node_fault_key(kind, subject);
  }
}

std::string_view node_of_fault_key(std::string_view key) {
  return key.substr(0, key.find(kKindSeparator));
}

std::string fault_id(const FaultRecord& record) {
  return "f" + std::to_string(record.opening_term) + "-" + std::to_string(record.number);
}

void FaultList::begin_term(std::uint64_t term) {
  opening_term_ = term;
  const auto enter = [term](FaultRecord& record) {
    record.opening_term = record.opening_term == 0 ? term : record.opening_term;
  };
  for (auto& [key, record] : open_) enter(record);
  for (FaultRecord& record : cleared_) enter(record);
  for (FaultRecord& record : restored_) enter(record);
  for (FaultRecord& record : changes_) enter(record);
}

void FaultList::restore(FaultHistory history) {
  open_ = std::move(history.open);
  cleared_ = std::move(history.cleared);
  restored_.assign(cleared_.rbegin(), cleared_.rend());
  changes_ = open();
}

bool FaultList::raise(const std::string& key, const FaultObservation& observation, std::chrono::nanoseconds now) {
  const auto [entry, opened] = open_.try_emplace(key);
  FaultRecord& record = entry->second;
  if (opened) {
    record.opening_term = opening_term_;
    record.number = ++last_number_;
    record.since = observation.since.value_or(now);
    record.detection_latency_bound = observation.detection_latency_bound;
  } else if (observation.kind < record.kind ||
             (observation.kind == record.kind && observation.severity <= record.severity)) {
    return false;
  }
  const bool is_new = opened || observation.kind != record.kind;
  record.kind = observation.kind;
  record.severity = opened ? observation.severity : std::max(record.severity, observation.severity);
  record.subject = observation.subject;
  record.description = clipped(observation.description);
  changes_.push_back(record);
  return is_new;
}

FaultRecord* FaultList::find(const FaultRecord& same) {
  const auto is_it = [&](const FaultRecord& one) {
    return one.opening_term == same.opening_term && one.number == same.number;
  };
  const auto open = std::find_if(open_.begin(), open_.end(), [&](const auto& entry) { return is_it(entry.second); });
  if (open != open_.end()) return &open->second;
  const auto cleared = std::find_if(cleared_.begin(), cleared_.end(), is_it);
  return cleared == cleared_.end() ? nullptr : &*cleared;
}

void FaultList::refine(FaultRecord& ours, const FaultRecord& better) {
  if (better.kind < ours.kind || (better.kind == ours.kind && better.severity <= ours.severity)) return;
  ours.kind = better.kind;
  ours.severity = std::max(ours.severity, better.severity);
  ours.subject = better.subject;
  ours.description = better.description;
  changes_.push_back(ours);
}

void FaultList::adopt(const std::string& key, FaultRecord record, std::chrono::nanoseconds now) {
  if (FaultRecord* ours = find(record)) return refine(*ours, record);
  // If this list published the record and dropped it at once, two leaders would adopt it from each other for ever.
  const bool too_old =
      record.cleared_at && cleared_.size() >= kClearedKept && *record.cleared_at <= *cleared_.back().cleared_at;
  if (too_old) return;
  const auto open = open_.find(key);
  if (!record.cleared_at && open == open_.end()) {
    changes_.push_back(open_.emplace(key, std::move(record)).first->second);
    return;
  }
  if (!record.cleared_at) {  // both supervisors observed the same failure: one record remains open
    refine(open->second, record);
    record.cleared_at = now;
  }
  changes_.push_back(record);
  const auto older = [&](const FaultRecord& one) { return one.cleared_at <= record.cleared_at; };
  const auto place = std::find_if(cleared_.begin(), cleared_.end(), older);
  cleared_.insert(place, std::move(record));
  trim();
}

void FaultList::trim() {
  if (cleared_.size() > kClearedKept) cleared_.pop_back();
}

bool FaultList::remembers(msg::CauseKind kind) const {
  const auto same = [kind](const FaultRecord& record) { return record.kind == kind; };
  return std::any_of(cleared_.begin(), cleared_.end(), same) ||
         std::any_of(open_.begin(), open_.end(), [&](const auto& entry) { return same(entry.second); });
}

bool FaultList::remembers(const FaultObservation& observation, std::chrono::nanoseconds since) const {
  const auto same = [&](const FaultRecord& record) {
    return record.kind == observation.kind && record.description == observation.description && record.since >= since;
  };
  return std::any_of(cleared_.begin(), cleared_.end(), same) ||
         std::any_of(open_.begin(), open_.end(), [&](const auto& entry) { return same(entry.second); });
}

void FaultList::clear(std::string_view key, std::chrono::nanoseconds now) {
  const auto entry = open_.find(key);
  if (entry == open_.end()) return;
  FaultRecord record = std::move(entry->second);
  open_.erase(entry);
  record.cleared_at = now;
  changes_.push_back(record);
  cleared_.push_front(std::move(record));
  trim();
}

const FaultRecord* FaultList::open(std::string_view key) const {
  const auto entry = open_.find(key);
  return entry == open_.end() ? nullptr : &entry->second;
}

std::vector<FaultRecord> FaultList::open() const {
  std::vector<FaultRecord> records;
  for (const auto& [key, record] : open_) records.push_back(record);
  std::sort(records.begin(), records.end(), [](const FaultRecord& a, const FaultRecord& b) {
    return std::tie(a.opening_term, a.number) < std::tie(b.opening_term, b.number);
  });
  return records;
}

std::vector<FaultRecord> FaultList::take_restored() {
  return std::exchange(restored_, {});
}

std::vector<FaultRecord> FaultList::take_changes() {
  return std::exchange(changes_, {});
}

}  // namespace hecaton::services
