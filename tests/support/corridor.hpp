#pragma once
/// Balls in a corridor that block each other.

#include <string>

#include "planner/cell.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::test {

/// Balls of 0.1 m in a closed corridor 0.22 m wide and 3 m long. In a bay of 0.4 m at `bay` [m] one ball can let
/// other balls pass.
inline planner::Cell corridor(int balls, double bay, double stall_timeout) {
  planner::Cell cell;
  cell.name = "corridor";
  for (int i = 0; i < balls; ++i) {
    planner::PlannedArm planned;
    planned.arm = planar_point("ball" + std::to_string(i));
    planned.arm.limits.lower = joints({-1.5, -0.11});  // otherwise most samples of a search lie in the walls
    planned.arm.limits.upper = joints({1.5, 0.5});
    planned.parameters.damper = {.influence_distance = 0.12, .security_distance = 0.02, .convergence_speed = 0.5};
    planned.parameters.coordination.stall_timeout = stall_timeout;
    cell.arms.push_back(planned);
  }
  cell.tasks.time_limit = balls > 2 ? 90.0 : 25.0;
  const auto wall = [&](const char* name, double x_from, double x_to, double y_from, double y_to) {
    cell.scene.obstacles.push_back(box_obstacle(name, {0.5 * (x_from + x_to), 0.5 * (y_from + y_to), 0.0},
                                                {0.5 * (x_to - x_from), 0.5 * (y_to - y_from), 0.5}));
  };
  wall("south", -1.6, 1.6, -0.21, -0.11);
  wall("north_west", -1.6, bay - 0.2, 0.11, 0.21);
  wall("north_east", bay + 0.2, 1.6, 0.11, 0.21);
  wall("bay_west", bay - 0.3, bay - 0.2, 0.21, 0.6);
  wall("bay_east", bay + 0.2, bay + 0.3, 0.21, 0.6);
  wall("bay_end", bay - 0.3, bay + 0.3, 0.5, 0.6);
  wall("west", -1.6, -1.5, -0.2, 0.2);
  wall("east", 1.5, 1.6, -0.2, 0.2);
  return cell;
}

/// Start and goal of ball `i` of `balls` [m]. The balls must reverse their order.
inline planner::JointVector corridor_start(int i, int balls) {
  return joints({balls == 1 ? 0.0 : -1.0 + 2.0 * i / (balls - 1), 0});
}
inline planner::JointVector corridor_goal(int i, int balls) {
  return joints({-corridor_start(i, balls)[0], 0});
}

}  // namespace hecaton::test
