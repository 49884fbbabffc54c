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

/// Fault kinds are those of msg::CauseKind's section Faults, from the weakest explanation to the strongest: when a
/// stronger one turns up for the same cause, the record is corrected instead of a second one opened.
struct FaultRecord {
  std::uint64_t life = 0;    ///< of the supervisor that opened it
  std::uint64_t number = 0;  ///< unique in that life, from 1
  msg::CauseKind kind{};
  msg::Severity severity{};
  std::string subject;  ///< node, host or arm
  std::string seen;     ///< a sentence
  std::chrono::nanoseconds since{0};
  std::optional<std::chrono::nanoseconds> detected_within{};  ///< as first seen, see FaultSight
  std::optional<std::chrono::nanoseconds> cleared;
  bool operator==(const FaultRecord&) const = default;
};

/// Why the arms stand still that depend on what is faulty.
[[nodiscard]] inline msg::Cause held_by(const FaultRecord& fault) {
  return make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, fault.subject, fault.seen);
}

/// Faults as they outlive their supervisor.
struct FaultHistory {
  std::map<std::string, FaultRecord, std::less<>> open;  ///< by cause
  std::deque<FaultRecord> over;                          ///< newest first
  bool operator==(const FaultHistory&) const = default;
};

/// What is wrong, as somebody sees it now.
struct FaultSight {
  msg::CauseKind kind{};
  msg::Severity severity{};
  std::string subject;
  std::string seen;
  /// It was seen no later than this after it happened: the time since the last sign that all was well. Empty: unknown.
  std::optional<std::chrono::nanoseconds> detected_within{};
  /// When it happened, if that is known to be earlier.
  std::optional<std::chrono::nanoseconds> since{};
};

class FaultList {
 public:
  static constexpr std::size_t kRemembered = 64;  ///< faults that are over

  /// From now on faults are opened in this life, see FaultRecord; those that were opened in none, by nobody who led,
  /// are of this one, too.
  void begin_life(std::uint64_t life);
  /// Goes on with the faults of an earlier supervisor. All are to be told again; only the open ones are news.
  void recall(FaultHistory history);
  [[nodiscard]] FaultHistory history() const { return {open_, over_}; }

  /// Opens a fault for `cause`, or corrects the open one where `sight` explains it better or makes it more severe.
  /// True: the cause has a fault of this kind only now.
  bool raise(const std::string& cause, const FaultSight& sight, std::chrono::nanoseconds now);
  /// Takes over what another supervisor told of `cause`, as it is: its life, its number, its times. Of a record that is
  /// known only a better explanation is news. Where `cause` has an open fault of ours already, the other is over.
  void adopt(const std::string& cause, FaultRecord record, std::chrono::nanoseconds now);
  /// Ends the open fault of `cause`; nothing happens without.
  void clear(std::string_view cause, std::chrono::nanoseconds now);

  /// One of this kind is remembered.
  [[nodiscard]] bool knows(msg::CauseKind kind) const;
  /// The same was seen before, and is remembered; `since`: not earlier than this.
  [[nodiscard]] bool knows(const FaultSight& sight,
                           std::chrono::nanoseconds since = std::chrono::nanoseconds::min()) const;
  /// The open fault of `cause`, or null.
  [[nodiscard]] const FaultRecord* open(std::string_view cause) const;
  [[nodiscard]] std::vector<FaultRecord> open() const;  ///< oldest first
  /// The last kRemembered that are over, newest first.
  [[nodiscard]] const std::deque<FaultRecord>& over() const { return over_; }
  /// Those that were over already when they were recalled, oldest first; empty from the second call on.
  [[nodiscard]] std::vector<FaultRecord> take_recalled();
  /// Every other state of every record since the last call, in order.
  [[nodiscard]] std::vector<FaultRecord> take_changes();

 private:
  [[nodiscard]] FaultRecord* find(const FaultRecord& same);
  void explain(FaultRecord& ours, const FaultRecord& better);
  void trim();

  std::map<std::string, FaultRecord, std::less<>> open_;  // by cause
  std::deque<FaultRecord> over_;
  std::vector<FaultRecord> recalled_;
  std::vector<FaultRecord> changes_;
  std::uint64_t life_ = 0;
  std::uint64_t last_number_ = 0;
};

}  // namespace hecaton::services
