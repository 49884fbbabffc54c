#include "planner/rollout/rollout_policy.hpp"

#include <algorithm>

namespace hecaton::planner {
namespace {

/// After moving freely for this long the arm is not blocked any more [s].
constexpr double kOutOfTrouble = 0.5;
/// A blocked arm waits no longer for an answer before it deviates [s].
constexpr double kLongestWait = 0.15;
/// Time between two lookaheads [s].
constexpr double kLookaheadInterval = 0.1;
/// Least time between two velocity samples of an obstacle [s].
constexpr double kCourse = 0.05;
/// Slower obstacles are left to the dampers [m/s].
constexpr double kMoves = 0.02;
/// Escapes of a lookahead for each manoeuvre of a blocked arm: lookaheads are short, and escapes are rare.
constexpr int kEscapes = 2;

/// True if the obstacle at its present velocity may come within dᵢ of the arm's reach.
bool may_come_near(const CellGeometry& geometry, int obstacle, const world::ObstacleState& state, double influence) {
  const world::BoundingSphere& reach = geometry.arm_reach(geometry.self());
  const Eigen::Vector3d& v = state.velocity.linear;
  for (const Body& body : geometry.obstacle_bodies(obstacle)) {
    const Eigen::Vector3d offset = state.X_WO.linear() * body.bound.centre;
    const double turning = state.velocity.angular.norm() * offset.norm();
    if (v.norm() + turning < kMoves) continue;
    const Eigen::Vector3d from = reach.centre - (state.X_WO.translation() + offset);
    const double nearest_at =
        v.isZero() ? 0.0 : std::clamp(from.dot(v) / v.squaredNorm(), 0.0, state.age + kLookaheadTime);
    const double near = reach.radius + body.bound.radius + influence + turning * kLookaheadTime;
    if ((from - nearest_at * v).norm() < near) return true;
  }
  return false;
}

bool something_comes(const ArmController& controller, const TickResult& result,
                     std::span<const world::ObstacleState> obstacles) {
  if (result.status == TickStatus::kHolding || result.status == TickStatus::kStaleInput) return false;
  const CellGeometry& geometry = controller.geometry();
  const double influence = controller.parameters().damper.influence_distance;
  for (int i = 0; i < std::min(geometry.obstacle_count(), static_cast<int>(obstacles.size())); ++i) {
    if (may_come_near(geometry, i, obstacles[i], influence)) return true;
  }
  return false;
}

RolloutQuestion make_question(const ArmController& controller, std::span<const ArmObservation> arms,
                              std::span<const world::ObstacleState> obstacles) {
  RolloutQuestion question;
  const int self = controller.geometry().self();
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    RolloutArm& arm = question.arms.emplace_back();
    if (i == self) {
      arm.q = controller.setpoint().q;
      arm.qd = controller.setpoint().qd;
      arm.has_goal = controller.goal().has_value();
      if (arm.has_goal) arm.q_goal = *controller.goal();
      arm.plans = true;
      arm.speed = controller.speed();
      arm.memory = controller.memory();
      arm.memory.rollout_wait = 0.0;       // kContinue means to deviate now
      arm.memory.detour.of_route = false;  // the simulation ends at the next point of the route
      continue;
    }
    const ArmObservation& seen = arms[i];
    const JointLimits& limits = controller.geometry().arms()[i].limits;
    arm.q = (seen.q + seen.qd * seen.age).cwiseMax(limits.lower).cwiseMin(limits.upper);
    arm.qd = seen.qd;
    arm.q_goal = seen.q_goal;
    arm.has_goal = seen.has_goal;
    arm.plans = seen.plans;
    arm.foreign = seen.foreign;
    arm.speed = seen.speed;
    arm.position_uncertainty = seen.position_uncertainty;
    // The seeds of other arms are unknown; each gets a stream of its own.
    arm.memory = LocalMemory(static_cast<std::uint64_t>(i) + 1);
    arm.memory.right_of_way.priority = seen.priority;
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
      strongest_(parameters.acceleration_of_obstacles),
      random_(seed),
      since_answer_(parameters.rollout.interval),
      since_lookahead_(kLookaheadInterval),
      horizon_(parameters.rollout.horizon) {
  if (!parameters.method->traits().coordinates) parameters_.candidates = 0;
}

std::optional<double> RolloutPolicy::rollout_wait() const {
  const bool could_ask =
      open_ != Open::kBlockedArm && parameters_.candidates > 0 && since_answer_ >= parameters_.interval;
  return could_ask ? std::optional(kLongestWait) : std::nullopt;
}

/// Differences refer to the times of measurement, because every state has its own age.
void RolloutPolicy::watch(std::span<const world::ObstacleState> obstacles, double dt) {
  const bool anew = courses_.size() != obstacles.size();
  courses_.resize(obstacles.size());
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    Course& course = courses_[i];
    const Eigen::Vector3d& velocity = obstacles[i].velocity.linear;
    if (anew) course = {velocity, obstacles[i].age, Eigen::Vector3d::Zero()};
    course.since += dt;
    const double between = course.since - obstacles[i].age;
    if (between < kCourse) continue;
    course.acceleration = (velocity - course.velocity) / between;
    if (course.acceleration.norm() > strongest_) course.acceleration.setZero();
    course.velocity = velocity;
    course.since = obstacles[i].age;
  }
}

std::vector<Eigen::Vector3d> RolloutPolicy::accelerations() const {
  std::vector<Eigen::Vector3d> all;
  for (const Course& course : courses_) all.push_back(course.acceleration);
  return all;
}

std::optional<RolloutQuestion> RolloutPolicy::next(const ArmController& controller, const TickResult& result,
                                                   std::span<const ArmObservation> arms,
                                                   std::span<const world::ObstacleState> obstacles) {
  const double dt = controller.control_period();
  since_answer_ += dt;
  const bool blocked = result.status == TickStatus::kFollowingBoundary || result.status == TickStatus::kDetouring ||
                       result.status == TickStatus::kBlocked || result.status == TickStatus::kYielding ||
                       result.awaiting_rollout;
  // On a route, RoutePolicy reacts instead; on a trajectory the arm waits, and away from a goal that it had reached.
  const bool trouble =
      blocked && controller.under_way() && !controller.route().under_way() && !controller.follows_trajectory();
  since_trouble_ = trouble ? 0.0 : since_trouble_ + dt;
  if (since_trouble_ > kOutOfTrouble) horizon_ = parameters_.horizon;
  since_lookahead_ += dt;
  if (parameters_.candidates > 0) watch(obstacles, dt);
  if (open_ != Open::kNone || parameters_.candidates == 0) return std::nullopt;
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    if (i != controller.geometry().self() && !arms[i].known) return std::nullopt;
  }
  // The lookahead comes first, because the other search may take long.
  const bool looks = since_lookahead_ >= kLookaheadInterval && something_comes(controller, result, obstacles);
  if (!looks && trouble && since_answer_ >= parameters_.interval) {
    open_ = Open::kBlockedArm;
    RolloutQuestion question = make_question(controller, arms, obstacles);
    question.accelerations = accelerations();
    question.candidates = parameters_.candidates;
    question.horizon = horizon_;
    question.seed = random_.next();
    horizon_ = std::min(parameters_.longest_horizon, horizon_ * parameters_.horizon_growth);
    return question;
  }
  if (!looks) return std::nullopt;
  open_ = Open::kLookahead;
  RolloutQuestion question = make_question(controller, arms, obstacles);
  question.accelerations = accelerations();
  question.candidates = kEscapes * parameters_.candidates;
  question.horizon = kLookaheadTime;
  question.seed = random_.next();
  question.lookahead = true;
  return question;
}

void RolloutPolicy::describe(MemoryArchive& archive) {
  archive.list(courses_, [&](Course& course) {
    archive.coordinates(course.velocity);
    archive(course.since);
    archive.coordinates(course.acceleration);
  });
  archive(random_);
  archive.number(open_, 0, static_cast<int>(Open::kLookahead));
  archive(since_answer_, since_lookahead_, since_trouble_, horizon_);
}

void RolloutPolicy::answered() {
  (open_ == Open::kLookahead ? since_lookahead_ : since_answer_) = 0.0;
  open_ = Open::kNone;
}

}  // namespace hecaton::planner
