#include "planner/rollout/rollout_policy.hpp"

#include <algorithm>

namespace hecaton::planner {
namespace {

/// An arm that went freely this long is out of its trouble [s].
constexpr double kOutOfTrouble = 0.5;
/// Nobody waits longer for an answer before turning aside [s].
constexpr double kLongestThought = 0.15;

RolloutQuestion make_question(const ArmController& controller, std::span<const ArmObservation> arms,
                              std::span<const world::ObstacleState> obstacles) {
  RolloutQuestion question;
  const int self = controller.geometry().self();
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    PlayedArm& arm = question.arms.emplace_back();
    if (i == self) {
      arm.q = controller.setpoint().q;
      arm.qd = controller.setpoint().qd;
      arm.q_goal = *controller.goal();
      arm.has_goal = true;
      arm.plans = true;
      arm.memory = controller.memory();
      arm.memory.time_to_think = 0.0;  // who goes on turns aside now
      continue;
    }
    const ArmObservation& seen = arms[i];
    const JointLimits& limits = controller.geometry().arms()[i].limits;
    arm.q = (seen.q + seen.qd * seen.age).cwiseMax(limits.lower).cwiseMin(limits.upper);
    arm.qd = seen.qd;
    arm.q_goal = seen.q_goal;
    arm.has_goal = seen.has_goal;
    arm.plans = seen.plans;
    arm.stray = seen.stray;
    // How the other chooses its subspaces is not known; that each is somebody else is.
    arm.memory = LocalMemory(static_cast<std::uint64_t>(i) + 1);
    arm.memory.right_of_way.claim = seen.claim;
  }
  for (const world::ObstacleState& obstacle : obstacles) {
    question.obstacles.push_back(obstacle);
    question.obstacles.back().X_WO = world::extrapolate(obstacle.X_WO, obstacle.velocity, obstacle.age);
  }
  return question;
}

}  // namespace

RolloutPolicy::RolloutPolicy(const LocalParameters& parameters, std::uint64_t seed)
    : parameters_(parameters.rollout),
      random_(seed),
      since_answer_(parameters.rollout.interval),
      horizon_(parameters.rollout.horizon) {
  if (parameters.method != Method::kBoundaryFollowing) parameters_.candidates = 0;
}

void RolloutPolicy::prepare(ArmController& controller) const {
  const bool could_ask = !open_ && parameters_.candidates > 0 && since_answer_ >= parameters_.interval;
  if (could_ask) controller.think_first(kLongestThought);
}

std::optional<RolloutQuestion> RolloutPolicy::next(const ArmController& controller, const TickResult& result,
                                                   std::span<const ArmObservation> arms,
                                                   std::span<const world::ObstacleState> obstacles) {
  const double dt = controller.control_period();
  since_answer_ += dt;
  const bool trouble = result.status == TickStatus::kFollowing || result.status == TickStatus::kDetouring ||
                       result.status == TickStatus::kBlocked ||
                       (result.status == TickStatus::kYielding && controller.under_way()) || result.thinks;
  since_trouble_ = trouble ? 0.0 : since_trouble_ + dt;
  if (since_trouble_ > kOutOfTrouble) horizon_ = parameters_.horizon;
  if (!trouble || open_ || parameters_.candidates == 0 || since_answer_ < parameters_.interval) return std::nullopt;
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    if (i != controller.geometry().self() && !arms[i].known) return std::nullopt;
  }
  open_ = true;
  RolloutQuestion question = make_question(controller, arms, obstacles);
  question.candidates = parameters_.candidates;
  question.horizon = horizon_;
  question.seed = random_.next();
  horizon_ = std::min(parameters_.longest_horizon, horizon_ * parameters_.horizon_growth);
  return question;
}

void RolloutPolicy::answered() {
  open_ = false;
  since_answer_ = 0.0;
}

}  // namespace hecaton::planner
