#pragma once
/// Configurations that differ by whole turns of joints: the tool is at the same place, the way there is not.

#include <functional>
#include <numbers>

#include "planner/model/arm.hpp"

namespace hecaton::planner {

inline constexpr double kWholeTurn = 2.0 * std::numbers::pi;  ///< [rad]

/// q with whole turns added to joints that repeat after them (repeats_after_turn), so that each is as near to `start`
/// as its limits allow [rad].
[[nodiscard]] JointVector nearest_turns(const Arm& arm, JointVector q, const JointVector& start);

/// The choice of turns whose straight way from `start` is blocked least, the shortest among equals: a joint may have to
/// go the long way round, because the short one leads through a table and has no way around it. `is_free` judges
/// configurations every 0.1 rad of the joint that moves most, the ends excluded. Tries the 16 shortest choices.
[[nodiscard]] JointVector turns_with_free_way(const Arm& arm, const JointVector& q, const JointVector& start,
                                              const std::function<bool(const JointVector&)>& is_free);

}  // namespace hecaton::planner
