#pragma once
/// What the states of a goal mean.

#include <idl/goal.h>

namespace hecaton::services {

/// Nothing more comes of the goal.
[[nodiscard]] inline bool is_over(msg::GoalState state) {
  return state != msg::GOAL_ACCEPTED && state != msg::GOAL_ACTIVE && state != msg::GOAL_BLOCKED;
}

}  // namespace hecaton::services
