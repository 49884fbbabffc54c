#include "planner/arm_controller.hpp"

#include <sstream>

#include "planner/goal_check.hpp"

namespace hecaton::planner {
namespace {

/// A measured position farther than this from the set-point means that the arm does not follow [rad | m].
constexpr double kLostTrack = 0.05;

}  // namespace

ArmController::ArmController(CellGeometry geometry, LocalParameters parameters, double control_period,
                             std::uint64_t seed)
    : geometry_(std::move(geometry)),
      parameters_(parameters),
      dt_(control_period),
      scratch_(geometry_),
      memory_{LocalMemory(seed)} {}

void ArmController::set_obstacles(std::span<const world::Obstacle> obstacles) {
  geometry_.set_obstacles(obstacles);
  scratch_.rebuild(geometry_);
}

std::string ArmController::reject_goal(const JointVector& q_goal, std::span<const world::ObstacleState> obstacles) {
  return planner::reject_goal(geometry_, q_goal, obstacles);
}

void ArmController::set_goal(const JointVector& q_goal) {
  goal_ = q_goal;
  // The same goal again, after the arm had been there and stepped aside, is a new one.
  if (!under_way()) memory_.local.q_goal = {};
}

void ArmController::cancel_goal() {
  goal_.reset();
}

TickResult ArmController::step(const MeasuredState& measured, std::span<const ArmObservation> arms,
                               std::span<const world::ObstacleState> obstacles, bool hold) {
  const bool lost = !setpoint_ || (setpoint_->q - measured.q).cwiseAbs().maxCoeff() > kLostTrack;
  if (lost) setpoint_ = measured;

  TickInput input;
  input.dt = dt_;
  input.q = setpoint_->q;
  input.qd = setpoint_->qd;
  input.tracking_error = measured.q - setpoint_->q;
  input.has_goal = goal_.has_value();
  if (goal_) input.q_goal = *goal_;
  input.hold = hold;
  input.arms = arms;
  input.obstacles = obstacles;
  TickResult result = tick(geometry_, parameters_, input, memory_, scratch_);
  setpoint_ = MeasuredState{result.q, result.qd};
  return result;
}

}  // namespace hecaton::planner
