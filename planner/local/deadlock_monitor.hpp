#pragma once
/// When the local planner is stuck: it still wants to go but the constraints leave little of the way.

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// [Lahouar06] section 4: ‖Δq‖ below a share (30 %) of the step that the goal alone would ask for.
/// differs from paper: compared with min(‖q_goal − q‖, Δq_max) instead of Δq_max, or it would fire near every goal; and
/// it looks at what the local planner intends before acceleration limits, or it would fire at every start.
[[nodiscard]] inline bool deadlocked(const JointVector& intended, const JointVector& wanted, double fraction) {
  return intended.norm() < fraction * wanted.norm();
}

}  // namespace hecaton::planner
