#include "planner/rollout/rollout_simulation.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace hecaton::planner {

RolloutSimulation::RolloutSimulation(const std::vector<Arm>& arms, std::vector<LocalParameters> parameters, double dt)
    : parameters_(std::move(parameters)), dt_(dt) {
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    geometries_.emplace_back(arms, i);
    scratch_.emplace_back(geometries_.back(), parameters_[i]);
  }
}

void RolloutSimulation::set_obstacles(std::span<const world::Obstacle> obstacles) {
  for (int i = 0; i < arms(); ++i) {
    geometries_[i].set_obstacles(obstacles);
    scratch_[i].rebuild(geometries_[i]);
  }
}

void RolloutSimulation::begin(std::span<const RolloutArm> arms, std::span<const world::ObstacleState> obstacles,
                              std::span<const Eigen::Vector3d> accelerations, double dt) {
  time_ = 0.0;
  dt_ = dt;
  accelerations_.assign(accelerations.begin(), accelerations.end());
  accelerations_.resize(obstacles.size(), Eigen::Vector3d::Zero());
  arms_.assign(arms.begin(), arms.end());
  obstacles_.assign(obstacles.begin(), obstacles.end());
  reached_.assign(arms.size(), -1.0);
  clearance_margin_.assign(arms.size(), std::numeric_limits<double>::infinity());
  clearance_margin_of_moving_ = clearance_margin_;
  seen_.resize(arms.size());
  for (world::ObstacleState& obstacle : obstacles_) obstacle.age = 0.0;
}

void RolloutSimulation::step() {
  for (int i = 0; i < arms(); ++i) {
    const RolloutArm& arm = arms_[i];
    seen_[i] = {arm.q,
                arm.qd,
                0.0,
                true,
                arm.plans,
                is_under_way(i),
                arm.q_goal,
                arm.memory.right_of_way.priority,
                arm.position_uncertainty};
    seen_[i].foreign = arm.foreign;
  }
  time_ += dt_;
  for (int i = 0; i < arms(); ++i) {
    RolloutArm& arm = arms_[i];
    if (arm.foreign) {
      const JointVector expected = arm.q + arm.qd * dt_;
      arm.q = expected.cwiseMax(limits(i).lower).cwiseMin(limits(i).upper);
      arm.qd = (arm.q.array() == expected.array()).select(arm.qd, 0.0);
      continue;
    }
    if (!arm.plans) {
      arm.qd.setZero();
      continue;
    }
    TickInput input;
    input.dt = dt_;
    input.q = arm.q;
    input.qd = arm.qd;
    input.q_goal = arm.q_goal;
    input.has_goal = arm.has_goal;
    input.arms = seen_;
    input.obstacles = obstacles_;
    input.speed_scaling = arm.speed;
    TickMemory memory{std::move(arm.memory)};
    const TickResult result = tick(geometries_[i], parameters_[i], input, memory, scratch_[i]);
    arm.memory = std::move(memory.local);
    if (time_ <= kLookaheadTime + 0.5 * dt_) {
      clearance_margin_[i] = std::min(clearance_margin_[i], result.clearance_margin);
      clearance_margin_of_moving_[i] = std::min(clearance_margin_of_moving_[i], result.clearance_margin_of_moving);
    }
    arm.q = result.q;
    arm.qd = result.qd;
    if (result.status == TickStatus::kReached && reached_[i] < 0.0) reached_[i] = time_;
  }
  const double gain = std::max(0.0, 1.0 - time_ / kAccelerationHorizon) * dt_;
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    world::ObstacleState& obstacle = obstacles_[i];
    obstacle.X_WO = world::extrapolate(obstacle.X_WO, obstacle.velocity, dt_);
    obstacle.velocity.linear += gain * accelerations_[i];
  }
}

}  // namespace hecaton::planner
