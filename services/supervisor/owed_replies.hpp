#pragma once
/// Replies to orders, kept back until the supervisor that stands by has heard the order too: so an order that was
/// acknowledged does not die with who acknowledged it.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

/// `Request`: what a reply answers.
template <class Request>
class OwedReplies {
 public:
  /// A standby that has not heard of an order by then keeps nobody waiting: it is deaf, which is a fault of its own.
  static constexpr Time kPatience = std::chrono::milliseconds(500);

  /// `mode`: sequence number of the first cell mode that contains the order.
  void owe(Request request, std::uint64_t mode, Time now) {
    owed_.push_back({std::move(request), mode, now + kPatience});
  }
  /// Those that may be given now. `heard`: sequence number of the newest mode that the standby has heard; empty: nobody
  /// stands by.
  [[nodiscard]] std::vector<Request> take(const std::optional<std::uint64_t>& heard, Time now) {
    std::vector<Request> due;
    std::erase_if(owed_, [&](Owed& owed) {
      const bool is_due = !heard || *heard >= owed.mode || now >= owed.until;
      if (is_due) due.push_back(std::move(owed.request));
      return is_due;
    });
    return due;
  }
  /// Who no longer leads has nothing to acknowledge.
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
