#pragma once
/// How far apart two configurations are, by the joint that is farthest.

#include "planner/local/goal_objective.hpp"

namespace hecaton::planner {

/// The largest distance of a joint between `a` and `b`, with joints without limits on the shorter way [rad | m].
[[nodiscard]] inline double farthest_joint(const JointLimits& limits, const JointVector& a, const JointVector& b) {
  return joint_difference(limits, a, b).cwiseAbs().maxCoeff();
}

}  // namespace hecaton::planner
