#pragma once
/// From what a client asks for to a joint configuration that may be tried, or the sentence that says why not.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <idl/goal.h>

#include "planner/collision/cell_geometry.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::services {

struct GoalAnswer {
  msg::Goal goal;
  bool accepted = false;
  planner::JointVector q_goal;  ///< [rad | m], when accepted
  std::string reason;           ///< when not
};

/// Joint goals and named ones are checked (limits, collision with itself and with obstacles where they are now); pose
/// goals are solved from `q_now` and then from random seeds until a solution passes the same check. Arms of fewer than
/// six joints meet what they can: position and tool axis with five, position alone with fewer. May take 0.1 s.
[[nodiscard]] GoalAnswer resolve_goal(const planner::CellGeometry& geometry, const msg::Goal& goal,
                                      const planner::JointVector& q_now,
                                      std::span<const world::ObstacleState> obstacles);

}  // namespace hecaton::services
