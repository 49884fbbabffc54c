#pragma once
/// A robot model as the fast simulation takes it.

#include <stdexcept>

#include "planner/model/arm.hpp"
#include "planner/strategy_search/run_kernel.hpp"

namespace hecaton::planner {

/// A cell, or what it asks for, that the off-line stage cannot simulate: what() says why in one sentence.
class ProblemError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The arm with its first `avoiding` joints; the others stay as they are in `q_rest` (of all joints) [rad | m]. Link
/// shapes become the capsules that enclose them. Throws ProblemError when it has more of anything than fits.
[[nodiscard]] FlatArm flatten(const Arm& arm, int avoiding, const JointVector& q_rest);

/// No point of the body's segment can be farther from the origin of the first joint [m].
[[nodiscard]] double reach_from_first_joint(const FlatArm& arm, const FlatBody& body);

/// The way from the first joint's axis to the farthest that any of the arm's capsules can be [m].
[[nodiscard]] double reach_of(const FlatArm& arm);

}  // namespace hecaton::planner
