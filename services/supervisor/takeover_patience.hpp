#pragma once
/// How long the planner in charge of an arm may hang before its standby takes over. Standard library only: time is an
/// argument.
///
/// Two planners on busy machines would take an arm from each other for ever: each fell silent for the takeover lease
/// now and then, and none had died. So whoever replaces a living planner is given twice the time; what was added is
/// taken back by halves while nothing happens.

#include <algorithm>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

class TakeoverPatience {
 public:
  static constexpr Time kCalm = std::chrono::seconds(10);

  /// `least`: as the cell file says; `most` ≥ least.
  TakeoverPatience(Time least, Time most) : least_(least), most_(std::max(least, most)), patience_(least) {}

  /// A planner that has not ended was replaced.
  void replaced(Time now) {
    patience_ = std::min(most_, 2 * at(now));
    since_ = now;
  }
  [[nodiscard]] Time at(Time now) const {
    Time patience = patience_;
    for (Time calm = now - since_; calm >= kCalm && patience > least_; calm -= kCalm) patience /= 2;
    return std::max(least_, patience);
  }

 private:
  Time least_, most_;
  Time patience_;
  Time since_{0};  ///< of the last replacement
};

}  // namespace hecaton::services
