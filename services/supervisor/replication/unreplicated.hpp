#pragma once
/// What the other supervisor is not known to have yet: orders, faults, and replies that wait for it.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/health.h>

#include "services/runtime/orders.hpp"
#include "services/supervisor/messages.hpp"

namespace hecaton::services {

/// Orders that the other supervisor is not known to have: it was cut off, hung or not there when they were given. A
/// supervisor that no longer leads gives them once more to the leader; otherwise a stop would be gone when a partition
/// heals.
///
/// In doubt an order counts as unreplicated. An order that a person has resumed on the other side meanwhile may then
/// have to be resumed once more.
class UnreplicatedOrders {
 public:
  /// `left`: by an earlier life.
  explicit UnreplicatedOrders(Orders left = {}) : left_(std::move(left)) {}

  /// We lead now, and have what was left. The other is not known to have any order of this term yet.
  void begin_to_lead() {
    left_ = known_ = told_ = {};
    since_ = 0;
    again_ = true;
  }
  /// A person gave this order, perhaps not for the first time: it may have been withdrawn unheard meanwhile. No arms:
  /// of the whole cell.
  void given(const std::vector<std::string>& arms) {
    again_ = true;
    if (arms.empty()) known_.cell = msg::Mode::MODE_RUN;
    for (const std::string& arm : arms) known_.arms.erase(arm);
  }
  /// The orders in the cell mode of this number.
  void published(const Orders& orders, std::uint64_t mode) {
    if (!std::exchange(again_, false) && orders == told_) return;
    told_ = orders;
    since_ = mode;
  }
  /// The other stands by and has received the cell mode of this number. True when that was news for it.
  bool heard(std::uint64_t mode) {
    if (again_ || mode < since_ || known_ == told_) return false;
    known_ = told_;
    return true;
  }
  /// Of these orders, those that the other is not known to have.
  [[nodiscard]] Orders unheard(const Orders& orders) const { return beyond(orders, known_); }

  /// We lead no more.
  void stand_back(const Orders& orders) { left_ = unheard(orders); }
  /// The leader publishes these orders. True when nothing is left of what there was.
  bool strike_out(const Orders& told) {
    if (left_.empty()) return false;
    left_ = beyond(left_, told);
    return left_.empty();
  }
  /// To be given once more to the leader.
  [[nodiscard]] const Orders& left() const { return left_; }

 private:
  Orders left_;
  Orders known_;             // to the other, under our term
  Orders told_;              // in the last cell mode
  std::uint64_t since_ = 0;  // number of the first cell mode with these
  bool again_ = true;        // the next cell mode counts as such
};

/// Faults that a supervisor published while it led and no later leader has published again yet. They stay on the bus
/// under the old term, so that the leader adopts them, however late it receives them; otherwise faults of one side of a
/// partition would be lost.
class UnreplicatedFaults {
 public:
  /// We lead no more. `term`: the last under which we did.
  void leave(FaultHistory account, std::uint64_t term) {
    term_ = term;
    left_.clear();
    for (auto& [cause, record] : account.open) left_.insert_or_assign(fault_id(record), ToldRecord{cause, record});
    for (FaultRecord& record : account.over) {
      std::string id = fault_id(record);
      left_.insert_or_assign(std::move(id), ToldRecord{{}, std::move(record)});
    }
  }
  /// Strikes out what another published under a later term, or under the same if it is another's that we remember. True
  /// when nothing is left of what there was.
  bool strike_out(const std::map<std::string, msg::Fault>& told) {
    if (left_.empty()) return false;
    std::erase_if(left_, [&](const auto& entry) {
      const auto found = told.find(entry.first);
      return found != told.end() && found->second.term() >= term_;
    });
    return left_.empty();
  }
  void clear() { left_.clear(); }
  /// By id. The cause of those that were over is empty: none can be open of them.
  [[nodiscard]] const std::map<std::string, ToldRecord>& left() const { return left_; }

 private:
  std::uint64_t term_ = 0;
  std::map<std::string, ToldRecord> left_;
};

/// Replies to orders, kept back until the standby has the order, too: an acknowledged order does not die with the
/// supervisor that acknowledged it. `Request`: what a reply answers.
template <class Request>
class DeferredReplies {
 public:
  /// A standby that has not received an order by then delays no reply: it is deaf, which is a fault of its own.
  static constexpr Time kPatience = std::chrono::milliseconds(500);

  /// `mode`: sequence number of the first cell mode that contains the order.
  void owe(Request request, std::uint64_t mode, Time now) {
    owed_.push_back({std::move(request), mode, now + kPatience});
  }
  /// Those that may be given now. `heard`: sequence number of the newest mode that the standby has; empty: no standby.
  [[nodiscard]] std::vector<Request> take(const std::optional<std::uint64_t>& heard, Time now) {
    std::vector<Request> due;
    std::erase_if(owed_, [&](Owed& owed) {
      const bool is_due = !heard || *heard >= owed.mode || now >= owed.until;
      if (is_due) due.push_back(std::move(owed.request));
      return is_due;
    });
    return due;
  }
  /// A supervisor that no longer leads has nothing to acknowledge.
  void drop() { owed_.clear(); }

 private:
  struct Owed {
    Request request;
    std::uint64_t mode;
    Time until;
  };
  std::vector<Owed> owed_;
};

}  // namespace hecaton::services
