#pragma once
/// What a planner's successor must know of its arm's goals: a value, without clocks.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <idl/goal.h>

#include "planner/model/limits.hpp"

namespace hecaton::services {

struct GoalAccount {
  static constexpr std::size_t kLongestName = 255;  ///< of a goal and of its client; longer ones are refused
  static constexpr std::size_t kHandled = 1024;     ///< are remembered: more than the bus hands over of any client
  static constexpr std::size_t kEnds = 4;           ///< are told again

  struct Active {
    std::string goal;
    std::string client;
    std::uint64_t sequence_number = 0;  ///< the client's
    double time_limit = 0.0;            ///< [s]; 0: none
    double elapsed = 0.0;               ///< since it was accepted [s]
    planner::JointVector q_goal;        ///< [rad | m]
    bool operator==(const Active&) const = default;
  };
  struct End {
    std::string goal;
    msg::GoalState state = msg::GoalState::GOAL_REACHED;
    bool operator==(const End&) const = default;
  };

  std::optional<Active> active;
  std::vector<End> ends;               ///< of the last goals that are over, the oldest first
  std::vector<std::uint64_t> handled;  ///< digests of goals and cancellations that were answered, the oldest first
  bool operator==(const GoalAccount&) const = default;
};

}  // namespace hecaton::services
