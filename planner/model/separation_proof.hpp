#pragma once
/// Proof that two links of one arm never come near each other, whatever its joints do.

#include "planner/model/collision_filter.hpp"

namespace hecaton::planner {

/// True when geometry a and b are proven to stay further apart than `apart` [m] in every configuration within the
/// limits: branch and bound over the joints between them, with at most `budget` distance evaluations. False when they
/// do come nearer, or when the budget does not suffice to tell.
[[nodiscard]] bool proven_apart(const RobotModel& model, int a, int b, const PairDistance& distance, double apart,
                                int budget);

}  // namespace hecaton::planner
