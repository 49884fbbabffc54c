#pragma once
/// What the states of a goal mean.

#include <idl/goal.h>

namespace hecaton::services {

/// Nothing more comes of the goal.
[[nodiscard]] inline bool is_over(msg::GoalState state) {
  return state != msg::GoalState::GOAL_ACCEPTED && state != msg::GoalState::GOAL_ACTIVE &&
         state != msg::GoalState::GOAL_BLOCKED;
}

}  // namespace hecaton::services
