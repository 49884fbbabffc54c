#pragma once
/// The planar point on its way among boxes: whole ticks, one after the other.

#include <array>
#include <limits>
#include <vector>

#include "planner/methods/registry.hpp"
#include "planner/tick.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {

/// One point among boxes; steps its own ticks and remembers the smallest distance to a box's surface.
struct Journey {
  Journey(const std::vector<world::Obstacle>& boxes, std::shared_ptr<const MotionMethod> method, std::uint64_t seed = 1)
      : geometry({test::planar_point()}, 0), obstacles(boxes), memory{LocalMemory(seed)}, scratch(geometry) {
    geometry.set_obstacles(obstacles);
    scratch.rebuild(geometry);
    parameters.method = std::move(method);
    for (const auto& box : boxes) states.push_back({box.X_WO, {}, 0.0});
    input.qd = test::joints({0, 0});
    input.has_goal = true;
    input.arms = observations;
    input.obstacles = states;
  }

  TickResult step() {
    TickResult result = tick(geometry, parameters, input, memory, scratch);
    input.q = result.q;
    input.qd = result.qd;
    for (const auto& box : obstacles) {
      const auto& half = std::get<world::Box>(box.shapes[0].shape).half_extents;
      const Eigen::Vector3d p(input.q[0], input.q[1], 0.0);
      const Eigen::Vector3d outside = ((p - box.X_WO.translation()).cwiseAbs() - half).cwiseMax(0.0);
      nearest = std::min(nearest, outside.norm() - 0.05);
    }
    return result;
  }

  /// Ticks until reached; the status of the last one.
  TickStatus drive(const JointVector& from, const JointVector& to, int most_ticks) {
    input.q = from;
    input.q_goal = to;
    TickResult result;
    for (ticks = 0; ticks < most_ticks; ++ticks) {
      result = step();
      if (result.status == TickStatus::kReached) break;
    }
    return result.status;
  }

  CellGeometry geometry;
  std::vector<world::Obstacle> obstacles;
  std::vector<world::ObstacleState> states;
  std::array<ArmObservation, 1> observations;
  LocalParameters parameters;
  TickMemory memory;
  TickScratch scratch;
  TickInput input;
  double nearest = std::numeric_limits<double>::infinity();
  int ticks = 0;
};

inline const std::vector<world::Obstacle> kWall{test::box_obstacle("wall", {0, 0, 0}, {0.1, 0.5, 0.2})};
/// Fig. 11: an L-shaped trap whose second box blocks the way along the first.
inline const std::vector<world::Obstacle> kCorner{test::box_obstacle("wall", {0, 0, 0}, {0.1, 0.6, 0.2}),
                                                  test::box_obstacle("shelf", {-0.4, 0.5, 0}, {0.4, 0.1, 0.2}),
                                                  test::box_obstacle("block", {0.9, 0.1, 0}, {0.1, 0.3, 0.2})};

}  // namespace hecaton::planner
