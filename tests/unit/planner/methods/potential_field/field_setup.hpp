#pragma once
/// An arm, obstacles that stand still, and the field between them.

#include <vector>

#include "planner/methods/potential_field/gradient_path.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::test {

struct FieldSetup {
  FieldSetup(const planner::Arm& arm, const std::vector<world::Obstacle>& obstacles,
             const planner::potential::PotentialParameters& parameters = {}, double margin = 0.005)
      : geometry(cell(arm, obstacles)),
        states(states_of(obstacles)),
        field(geometry, parameters),
        motion(geometry, states, {}, margin) {}

  planner::potential::FieldValue at(const planner::JointVector& q) {
    planner::potential::FieldValue value;
    field.evaluate(motion.poses(q), q, value);
    return value;
  }
  planner::potential::Descent descend(const planner::JointVector& from, const planner::JointVector& to,
                                      const planner::potential::DescentOptions& options = {}) {
    return planner::potential::descend(field, motion, geometry.own_arm().limits, from, to, options);
  }

  static planner::CellGeometry cell(const planner::Arm& arm, const std::vector<world::Obstacle>& obstacles) {
    planner::CellGeometry geometry({arm}, 0);
    geometry.set_obstacles(obstacles);
    return geometry;
  }
  static std::vector<world::ObstacleState> states_of(const std::vector<world::Obstacle>& obstacles) {
    std::vector<world::ObstacleState> states;
    for (const auto& obstacle : obstacles) states.push_back({obstacle.X_WO, {}, 0.0});
    return states;
  }

  planner::CellGeometry geometry;
  std::vector<world::ObstacleState> states;
  planner::potential::PotentialField field;
  planner::potential::FreeMotion motion;
};

inline world::Obstacle ball_obstacle(const Eigen::Vector3d& centre, double radius) {
  world::Obstacle obstacle;
  obstacle.name = "ball";
  obstacle.shapes.push_back({world::Sphere{radius}});
  obstacle.X_WO.translation() = centre;
  return obstacle;
}

}  // namespace hecaton::test
