#pragma once
/// Random situations of a cell: configurations and velocities of all arms, with or without contacts.

#include <vector>

#include "planner/cell.hpp"
#include "planner/local/random.hpp"
#include "planner/tick.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::test {

struct Situation {
  planner::TickInput input;
  std::vector<planner::ArmObservation> arms;
  std::vector<world::ObstacleState> obstacles;

  Situation(const planner::Cell& cell, int self, planner::Random& random) {
    for (const auto& planned : cell.arms) {
      planner::ArmObservation arm;
      const planner::JointLimits& limits = planned.arm.limits;
      arm.q.resize(limits.lower.size());
      arm.qd.resize(limits.lower.size());
      for (Eigen::Index j = 0; j < arm.q.size(); ++j) {
        arm.q[j] = random.uniform(std::max(limits.lower[j], -3.0), std::min(limits.upper[j], 3.0));
        arm.qd[j] = random.uniform(-1.0, 1.0) * limits.velocity[j];
      }
      arm.known = true;
      arm.plans = random.uniform() < 0.7;
      arm.age = random.uniform(0.0, 0.06);
      arms.push_back(arm);
    }
    const double time = random.uniform(0.0, 30.0);
    for (const auto& obstacle : cell.scene.obstacles) {
      const world::MotionState at = world::motion_at(obstacle, time);
      obstacles.push_back({at.X_WO, at.velocity, 0.01});
    }
    input.dt = cell.timing.control_period;
    input.q = arms[self].q;
    input.qd = arms[self].qd;
    input.q_goal = input.q;
    const planner::JointLimits& limits = cell.arms[self].arm.limits;
    for (Eigen::Index j = 0; j < input.q.size(); ++j) {
      input.q_goal[j] = random.uniform(std::max(limits.lower[j], -3.0), std::min(limits.upper[j], 3.0));
    }
    input.has_goal = true;
    input.arms = arms;
    input.obstacles = obstacles;
  }
  Situation(const Situation&) = delete;
  Situation& operator=(const Situation&) = delete;
};

inline planner::CellGeometry geometry_of(const planner::Cell& cell, int self) {
  planner::CellGeometry geometry(arms_of(cell), self);
  geometry.set_obstacles(cell.scene.obstacles);
  return geometry;
}

}  // namespace hecaton::test
