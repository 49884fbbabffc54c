#pragma once
/// What a planner does with what the other planner of its arm tells of a goal.

#include <cstdint>

#include <idl/goal.h>

#include "services/planner/duty.hpp"
#include "services/runtime/goal_state.hpp"

namespace hecaton::services {

enum class Heed : std::uint8_t {
  kFollow,
  kLater,  ///< once more is known: when the mandate has changed
  kIgnore,
};

/// `ready`: nothing is remembered any more of which it is unknown whether it counts.
[[nodiscard]] inline Heed heed(const msg::GoalStatus& status, const Duty& duty, bool ready) {
  if (!ready || duty.term() == 0) return Heed::kLater;
  // Who was replaced may hear of it here first.
  if (duty.in_charge()) return status.term() > duty.term() ? Heed::kLater : Heed::kIgnore;
  // An end is an end. But what was under way in an earlier term of the other's need not be any more: the bus hands over
  // the last word of whoever stands by now, too.
  return is_over(status.state()) || status.term() >= duty.term() ? Heed::kFollow : Heed::kIgnore;
}

}  // namespace hecaton::services
