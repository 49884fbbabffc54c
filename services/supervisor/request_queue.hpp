#pragma once
/// Requests to the supervisor: which it answers now, and which replies wait until the standby has the order, too.

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/supervisor/failover/leadership.hpp"
#include "services/supervisor/replication/unreplicated.hpp"

namespace hecaton::services {

class RequestQueue {
 public:
  /// `alone`: the cell has no other supervisor.
  explicit RequestQueue(bool alone) : alone_(alone) {}

  /// Of what has arrived, the requests to answer now, in their order. A supervisor that listens before it leads answers
  /// questions, and keeps orders until it leads, unless another may lead meanwhile. A standby answers nothing.
  [[nodiscard]] std::vector<msg::SupervisorRequest> take(std::vector<bus::Sample<msg::SupervisorRequest>> arrived,
                                                         Leadership::Role role) {
    const bool leads = role == Leadership::Role::kLeading;
    if (role == Leadership::Role::kStandingBy) early_.clear();
    std::vector<msg::SupervisorRequest> now;
    if (leads) now = std::exchange(early_, {});
    const bool answers = leads || (role == Leadership::Role::kListening && alone_);
    for (auto& sample : arrived) {
      if (!answers || sample.disposed) continue;
      const bool at_once = leads || sample.value.kind() == msg::RequestKind::REQUEST_STATUS;
      (at_once ? now : early_).push_back(std::move(sample.value));
    }
    return now;
  }

  /// Replies to orders that were obeyed.
  [[nodiscard]] DeferredReplies<msg::SupervisorRequest>& deferred() { return deferred_; }

 private:
  bool alone_;
  std::vector<msg::SupervisorRequest> early_;  ///< orders that came before we led
  DeferredReplies<msg::SupervisorRequest> deferred_;
};

}  // namespace hecaton::services
