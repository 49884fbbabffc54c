#pragma once
/// Arms that should move and stand. Pure: time is an argument.

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

/// An arm that stands for a moment without a reason is about to move, or its reason is on its way.
class StandingArms {
 public:
  static constexpr Time kLimit = std::chrono::seconds(1);
  static constexpr Time kPeriod = std::chrono::milliseconds(100);  ///< of update()

  /// True once in each period.
  [[nodiscard]] bool due(Time now) {
    if (now - updated_ < kPeriod) return false;
    updated_ = now;
    return true;
  }

  /// `reason`: a sentence that says why the arm stands although it should move; empty: it does not. Returns the
  /// sentence once the arm has stood for kLimit.
  [[nodiscard]] std::optional<std::string> update(const std::string& arm, std::optional<std::string> reason, Time now) {
    if (!reason) {
      since_.erase(arm);
      return std::nullopt;
    }
    const auto [entry, is_new] = since_.try_emplace(arm, now);
    if (now - entry->second < kLimit) return std::nullopt;
    return "arm " + arm + " should move, but stands for more than 1 s: " + *std::move(reason);
  }

 private:
  Time updated_{0};
  std::map<std::string, Time> since_;
};

}  // namespace hecaton::services
