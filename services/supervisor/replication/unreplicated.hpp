#pragma once
/// Orders, faults and replies that wait until the other supervisor has them. Pure: time is an argument.
///
/// A supervisor acknowledges in its heartbeat the newest cell mode that it has received from the leader. From this the
/// leader knows which orders the other supervisor has.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/health.h>

#include "services/runtime/orders.hpp"
#include "services/runtime/stall_compensated_clock.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

/// Orders that the other supervisor may not have, because it was cut off, hung or not running when a person gave them.
/// A supervisor that no longer leads requests them from the new leader. Otherwise a stop would be lost when a partition
/// heals.
///
/// In doubt an order counts as unreplicated: a person may then have to resume it a second time.
class UnreplicatedOrders {
 public:
  /// `pending`: from the checkpoint.
  explicit UnreplicatedOrders(Orders pending = {}) : pending_(std::move(pending)) {}

  /// This supervisor leads and has taken over pending(). No order of its term is acknowledged yet.
  void become_leader() {
    pending_ = acknowledged_ = published_ = {};
    published_since_ = 0;
    publishes_again_ = true;
  }
  /// A person gave this order, perhaps once more after a resume that the other supervisor has not received. `arms`
  /// empty: the whole cell.
  void given(const std::vector<std::string>& arms) {
    publishes_again_ = true;
    if (arms.empty()) {
      acknowledged_.cell = msg::Mode::MODE_RUN;
      acknowledged_.speed = kFullSpeed;
    }
    for (const std::string& arm : arms) {
      acknowledged_.arms.erase(arm);
      acknowledged_.speeds.erase(arm);
    }
  }
  /// The cell mode with sequence number `mode` contains `orders`.
  void published(const Orders& orders, std::uint64_t mode) {
    if (!std::exchange(publishes_again_, false) && orders == published_) return;
    published_ = orders;
    published_since_ = mode;
  }
  /// The other supervisor has acknowledged the cell mode with sequence number `mode`. Returns true when it has new
  /// orders by that.
  bool acknowledged(std::uint64_t mode) {
    if (publishes_again_ || mode < published_since_ || acknowledged_ == published_) return false;
    acknowledged_ = published_;
    return true;
  }
  /// The part of `orders` that the other supervisor has not acknowledged.
  [[nodiscard]] Orders unacknowledged(const Orders& orders) const { return beyond(orders, acknowledged_); }

  /// This supervisor no longer leads. `orders`: in force until now.
  void step_down(const Orders& orders) { pending_ = unacknowledged(orders); }
  /// Removes orders that the leader publishes. Returns true when the last pending order was removed.
  bool remove_published(const Orders& published) {
    if (pending_.empty()) return false;
    pending_ = beyond(pending_, published);
    return pending_.empty();
  }
  /// To be requested from the leader.
  [[nodiscard]] const Orders& pending() const { return pending_; }

 private:
  Orders pending_;
  Orders acknowledged_;                // under this supervisor's term
  Orders published_;                   // in the last cell mode
  std::uint64_t published_since_ = 0;  // sequence number of the first cell mode with these orders
  bool publishes_again_ = true;        // the next cell mode counts as the first with its orders
};

/// Faults that a supervisor published while it led and that no later leader has published again. They stay on the bus
/// under the old term until a leader adopts them. Otherwise faults of one side of a partition would be lost.
class UnreplicatedFaults {
 public:
  /// This supervisor no longer leads. `term`: the last under which it did.
  void step_down(FaultHistory history, std::uint64_t term) {
    term_ = term;
    pending_.clear();
    for (auto& [key, record] : history.open) pending_.insert_or_assign(fault_id(record), KeyedFaultRecord{key, record});
    for (FaultRecord& record : history.cleared) {
      std::string id = fault_id(record);
      pending_.insert_or_assign(std::move(id), KeyedFaultRecord{{}, std::move(record)});
    }
  }
  /// Removes faults that the other supervisor published under this term or a later one. Returns true when the last
  /// pending fault was removed. An equal term is the other supervisor's, whose checkpoint this one has: two supervisors
  /// never take the same term.
  bool remove_published(const std::map<std::string, msg::Fault>& published) {
    if (pending_.empty()) return false;
    std::erase_if(pending_, [&](const auto& entry) {
      const auto found = published.find(entry.first);
      return found != published.end() && found->second.term() >= term_;
    });
    return pending_.empty();
  }
  void clear() { pending_.clear(); }
  /// By id. The key of cleared faults is empty: an adopted one cannot be open.
  [[nodiscard]] const std::map<std::string, KeyedFaultRecord>& pending() const { return pending_; }

 private:
  std::uint64_t term_ = 0;
  std::map<std::string, KeyedFaultRecord> pending_;
};

/// Replies that wait until the standby has the order, too: an acknowledged order survives the supervisor that
/// acknowledged it. `Request`: what a reply answers.
template <class Request>
class DeferredReplies {
 public:
  /// A standby that does not acknowledge within this delays no reply. That it hears nothing is a fault of its own.
  static constexpr Time kTimeout = std::chrono::milliseconds(500);

  /// `mode`: sequence number of the first cell mode that contains the order.
  void add(Request request, std::uint64_t mode, Time now) {
    deferred_.push_back({std::move(request), mode, now + kTimeout});
  }
  /// Returns and removes the requests that may be answered now. `acknowledged`: sequence number of the newest mode that
  /// the standby has; empty: there is no standby.
  [[nodiscard]] std::vector<Request> take(const std::optional<std::uint64_t>& acknowledged, Time now) {
    std::vector<Request> due;
    std::erase_if(deferred_, [&](Deferred& deferred) {
      const bool is_due = !acknowledged || *acknowledged >= deferred.mode || now >= deferred.until;
      if (is_due) due.push_back(std::move(deferred.request));
      return is_due;
    });
    return due;
  }
  /// This supervisor no longer leads: it has nothing to acknowledge.
  void clear() { deferred_.clear(); }

 private:
  struct Deferred {
    Request request;
    std::uint64_t mode;
    Time until;
  };
  std::vector<Deferred> deferred_;
};

}  // namespace hecaton::services
