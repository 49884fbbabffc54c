#pragma once
/// Where an arm stands of which nothing is heard any more (docs/design/0009-lost-arms.md).

#include "planner/model/arm.hpp"

namespace hecaton::planner {

/// Every joint is at rest within `position_uncertainty` of `q`, either way [rad | m].
struct ReachableStopSet {
  JointVector q;
  JointVector position_uncertainty;
};

/// Of an arm that was in (q, q̇), moved on within its limits in whatever way, and began its stop profile no later than
/// `moved_for` [s] afterwards.
[[nodiscard]] ReachableStopSet reachable_stop_set(const JointLimits& limits, const JointVector& q,
                                                  const JointVector& qd, double moved_for);

/// How far the points of something that is fixed to link `link`, all of them within `extent` [m] of the link's origin,
/// move at most per joint rate: [m/rad] for turning joints, 1 for shifting ones, whatever the configuration (within
/// limits, where a joint shifts).
[[nodiscard]] JointVector longest_levers(const Arm& arm, int link, double extent);

}  // namespace hecaton::planner
