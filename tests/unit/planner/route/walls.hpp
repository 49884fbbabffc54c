#pragma once
/// Walls for the planar point.

#include <algorithm>
#include <limits>
#include <vector>

#include "planner/route/route_policy.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::test {

/// The wall at x = 0 leaves a gap of `gap` at y = ±`at`, between the joint limits −3 … 3 [m].
inline std::vector<world::Obstacle> wall_with_gap(double at, double gap) {
  const double below = at - 0.5 * gap + 4.0;
  const double above = 4.0 - at - 0.5 * gap;
  return {box_obstacle("below", {0, -4.0 + 0.5 * below, 0}, {0.1, 0.5 * below, 0.5}),
          box_obstacle("above", {0, 4.0 - 0.5 * above, 0}, {0.1, 0.5 * above, 0.5})};
}

inline std::vector<world::ObstacleState> states_of(const std::vector<world::Obstacle>& obstacles) {
  std::vector<world::ObstacleState> states;
  for (const auto& obstacle : obstacles) states.push_back({obstacle.X_WO, {}, 0.0});
  return states;
}

/// Distance from the ball's surface to the nearest box [m].
inline double clearance_at(const planner::JointVector& q, const std::vector<world::Obstacle>& boxes,
                           const std::vector<world::ObstacleState>& states) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const auto& half = std::get<world::Box>(boxes[i].shapes[0].shape).half_extents;
    const Eigen::Vector3d from = Eigen::Vector3d(q[0], q[1], 0.0) - states[i].X_WO.translation();
    nearest = std::min(nearest, (from.cwiseAbs() - half).cwiseMax(0.0).norm() - 0.05);
  }
  return nearest;
}

}  // namespace hecaton::test
