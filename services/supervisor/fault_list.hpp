#pragma once
/// The faults of a cell: one record for each occurrence. Pure: time is an argument.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <idl/health.h>

#include "services/runtime/cause.hpp"

namespace hecaton::services {

/// One occurrence of a fault. Kinds are those of msg::CauseKind's section Faults, ordered from the weakest explanation
/// to the strongest: a stronger explanation of the same cause corrects the record and opens no second one.
struct FaultRecord {
  std::uint64_t opening_term = 0;  ///< term of the supervisor that opened it; 0: it has not led yet
  std::uint64_t number = 0;        ///< unique within that term, from 1
  msg::CauseKind kind{};
  msg::Severity severity{};
  std::string subject;      ///< node, host or arm
  std::string description;  ///< a sentence
  std::chrono::nanoseconds since{0};
  std::optional<std::chrono::nanoseconds> detection_latency_bound{};  ///< at its opening, see FaultObservation
  std::optional<std::chrono::nanoseconds> cleared_at{};               ///< empty: it is open
  bool operator==(const FaultRecord&) const = default;
};

/// Why arms stand still that depend on the faulty node.
[[nodiscard]] inline msg::Cause held_by(const FaultRecord& fault) {
  return make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, fault.subject, fault.description);
}

/// Faults as one supervisor hands them to the next.
struct FaultHistory {
  std::map<std::string, FaultRecord, std::less<>> open;  ///< by key
  std::deque<FaultRecord> cleared;                       ///< newest first
  bool operator==(const FaultHistory&) const = default;
};

/// A failure as the detector observes it now.
struct FaultObservation {
  msg::CauseKind kind{};
  msg::Severity severity{};
  std::string subject;
  std::string description;
  /// Upper bound of the time from the failure to this observation: the time since the last sign that all was well.
  /// Empty: unknown.
  std::optional<std::chrono::nanoseconds> detection_latency_bound{};
  /// Time of the failure, if it is known to be earlier than the observation.
  std::optional<std::chrono::nanoseconds> since{};
};

/// Key in the FaultList of a fault of this node. The kinds that explain each other share the key of the node;
/// others have keys of their own: those from CAUSE_DUPLICATE_NODE on, but for CAUSE_CONTACT.
[[nodiscard]] std::string node_fault_key(msg::CauseKind kind, const std::string& node);
/// Key of a fault of this kind and subject (node, arm, host or link).
[[nodiscard]] std::string fault_key(msg::CauseKind kind, const std::string& subject);
/// The node of a key that node_fault_key() made; other keys are returned unchanged.
[[nodiscard]] std::string_view node_of_fault_key(std::string_view key);

/// Id of the occurrence in msg::Fault: "f7-12".
[[nodiscard]] std::string fault_id(const FaultRecord& record);

struct KeyedFaultRecord {
  std::string key;
  FaultRecord record;
};

/// Open and cleared faults. A key has at most one open fault.
class FaultList {
 public:
  static constexpr std::size_t kClearedKept = 64;

  /// The supervisor leads under `term`: new records carry it, and so do records that were opened under none.
  void begin_term(std::uint64_t term);
  /// Replaces the list by the faults of an earlier leader. All are published again; take_changes() returns the open
  /// ones, take_restored() the cleared ones.
  void restore(FaultHistory history);
  [[nodiscard]] FaultHistory history() const { return {open_, cleared_}; }

  /// Opens a fault for `key`, or corrects the open one if `observation` is of a stronger kind or more severe.
  /// Returns true when the key has a fault of this kind only now.
  bool raise(const std::string& key, const FaultObservation& observation, std::chrono::nanoseconds now);
  /// Adds a record that another supervisor published, with its identity and times. A record that the list
  /// has already is corrected by a stronger explanation only. If `key` has another open fault, the adopted record is
  /// cleared at `now`.
  void adopt(const std::string& key, FaultRecord record, std::chrono::nanoseconds now);
  /// Clears the open fault of `key`, if there is one.
  void clear(std::string_view key, std::chrono::nanoseconds now);

  /// The list has a fault of this kind.
  [[nodiscard]] bool remembers(msg::CauseKind kind) const;
  /// The list has this observation, as a fault that began at or after `since`.
  [[nodiscard]] bool remembers(const FaultObservation& observation,
                               std::chrono::nanoseconds since = std::chrono::nanoseconds::min()) const;
  /// The open fault of `key`, or null. Valid until the next change.
  [[nodiscard]] const FaultRecord* open(std::string_view key) const;
  [[nodiscard]] std::vector<FaultRecord> open() const;  ///< oldest first
  /// The last kClearedKept cleared faults, newest first.
  [[nodiscard]] const std::deque<FaultRecord>& cleared() const { return cleared_; }
  /// The faults that were cleared before restore(), oldest first; empty from the second call on.
  [[nodiscard]] std::vector<FaultRecord> take_restored();
  /// Every new state of every record since the last call, in order.
  [[nodiscard]] std::vector<FaultRecord> take_changes();

 private:
  [[nodiscard]] FaultRecord* find(const FaultRecord& same);
  void refine(FaultRecord& ours, const FaultRecord& better);
  void trim();

  std::map<std::string, FaultRecord, std::less<>> open_;  // by key
  std::deque<FaultRecord> cleared_;
  std::vector<FaultRecord> restored_;
  std::vector<FaultRecord> changes_;
  std::uint64_t opening_term_ = 0;
  std::uint64_t last_number_ = 0;
};

}  // namespace hecaton::services
