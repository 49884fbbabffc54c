#include "planner/methods/strategy/strategy_method.hpp"

#include <array>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/local/parameters.hpp"
#include "planner/methods/strategy/strategy.hpp"

namespace hecaton::planner {
namespace {

/// The arm takes the next step within this share of a step from its target, so that it need not stop in between.
constexpr double kNearly = 0.5;

}  // namespace

JointVector step_way_point(const StrategyParameters& parameters, const MethodInput& input, const MethodScene& scene,
                           std::span<Kinematics> arms, StrategyMemory& memory) {
  const CellGeometry& geometry = scene.geometry;
  const Arm& arm = geometry.own_arm();
  const StrategyParameters& p = parameters;
  const JointVector way = joint_difference(arm.limits, input.q, input.q_goal);
  if (!memory.under_way) begin_strategy(p, input.q, way, memory);
  if (!memory.under_way) return input.q_goal;
  const ReducedSubspace& plane = memory.plane;
  const Eigen::Index n = plane.u1.size();

  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    const Arm& other = geometry.arms()[i];
    if (i != geometry.self()) forward_kinematics(*other.model, other.X_WB, scene.arms[i].q, arms[i]);
  }
  Kinematics& own = arms[geometry.self()];
  const auto free = [&](const JointVector& avoiding) {
    JointVector q = input.q;
    q.head(n) = avoiding;
    if ((q.array() < arm.limits.lower.array()).any() || (q.array() > arm.limits.upper.array()).any()) return false;
    forward_kinematics(*arm.model, arm.X_WB, q, own);
    std::array<Clearance, 1> nearest;
    return scene.distance.clearances(
               {&own, arms, scene.poses.obstacles},
               {.others = p.distance, .self = scene.self_security_distance, .self_share = kSecurityShare},
               nearest) == 0;
  };
  const IsFree is_free = std::ref(free);  // small enough for std::function to hold it without allocating
  const bool there = (input.q.head(n) - plane.at(memory.x, memory.y)).norm() < kNearly * p.step;
  if (!there && !is_free(plane.at(memory.x, memory.y))) {
    memory.x = plane.u1.dot(input.q.head(n) - plane.q_start);
    memory.y = plane.u2.dot(input.q.head(n) - plane.q_start);
    take_step(p.step, is_free, memory);
  } else if (there) {
    take_step(p.step, is_free, memory);
  }
  if (memory.x == plane.distance && memory.y == 0.0) return input.q_goal;
  JointVector way_point = input.q_goal;
  way_point.head(n) = plane.at(memory.x, memory.y);
  return way_point;
}

namespace {

struct StrategyFollowingMemory {
  FollowerMemory follower;
  StrategyMemory strategy;

  void describe(MemoryArchive& archive) { archive(follower, strategy); }
};

/// Follows the boundary across the line to the goal [Mediavilla02, footnote of section 4]:
///
///     uᶠ = a u₁ + b u₂ to the goal,   uᵀ = −b u₁ + a u₂ across it, on the side of the strategy.
///
/// differs from paper: uᶠ includes the displacement out of the plane that dampers have caused.
void follow_in_strategy(const MethodInput& input, const JointVector& way, MethodState state) {
  auto& [follower, strategy] = state.memory.as<StrategyFollowingMemory>();
  const Eigen::Index n = strategy.plane.u1.size();
  const double a = strategy.plane.u1.dot(way.head(n));
  const double b = strategy.plane.u2.dot(way.head(n));
  JointVector across = JointVector::Zero(way.size());
  across.head(n) = strategy.side * (a * strategy.plane.u2 - b * strategy.plane.u1);
  follow_across({follower, state.deviation, state.random}, way, across, input.rows);
}

struct StepWorkspace final : MethodWorkspace {
  explicit StepWorkspace(const CellGeometry& geometry) : arms(geometry.arms().size()) {}
  void rebuild(const CellGeometry& /*geometry*/) override {}

  std::vector<Kinematics> arms;
};

}  // namespace

void StrategyKeys::visit(ParameterVisitor& visitor) {
  static constexpr std::array<std::string_view, 2> kDirections = {"1", "-1"};
  StrategyParameters& p = parameters;
  visitor.section("strategy");
  visitor.integer("joints", p.joints, 2, kMaxJoints);
  visitor.numbers("coefficients", std::span(p.strategy.coefficients).first(kMaxJoints - 2), p.coefficients,
                  {-kMostCoefficient, kMostCoefficient, ""});
  std::size_t direction = p.strategy.direction > 0.0 ? 0 : 1;
  visitor.word("direction", kDirections, direction);
  p.strategy.direction = direction == 0 ? 1.0 : -1.0;
  visitor.file("file", {"coefficients", "direction"});
  visitor.number("distance", p.distance, {0.001, 1.0, "m"});
  visitor.number("step", p.step, {1e-4, 1.0, "rad"});
}

std::optional<std::string> StrategyKeys::unfit(const RobotModel& robot) const {
  if (robot.has_followers) {
    return "must be given to an arm whose links all have joints of their own; some links of robot " + robot.name +
           " follow another joint";
  }
  const int joints = robot.joints();
  const int avoiding = avoiding_joints(parameters, joints);
  if (joints < 2 || avoiding > joints) {
    return "must be given to an arm with two joints at least, and as many as strategy.joints says; robot " +
           robot.name + " has " + std::to_string(joints);
  }
  if (parameters.coefficients != avoiding - 2) {
    return "must be given with strategy.coefficients of " + std::to_string(avoiding - 2) +
           " numbers, two fewer than joints that avoid, not " + std::to_string(parameters.coefficients);
  }
  return std::nullopt;
}

void StrategyFollowing::visit_parameters(ParameterVisitor& visitor) {
  BoundaryFollowing::visit_parameters(visitor);
  visit(visitor);
}

FollowerMemory& StrategyFollowing::follower_of(MethodMemory& memory) const {
  return memory.as<StrategyFollowingMemory>().follower;
}

Redirection StrategyFollowing::redirect(const MethodInput& input, const ConstrainedMotion& constrained,
                                        MethodState state) const {
  StrategyMemory& strategy = state.memory.as<StrategyFollowingMemory>().strategy;
  if (!strategy.under_way) {
    const JointVector way = joint_difference(input.limits, input.q, input.q_goal);
    begin_strategy(StrategyKeys::parameters, input.q, way, strategy);
  }
  return BoundaryFollowing::redirect(input, constrained, state);
}

void StrategyFollowing::start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const {
  if (!state.memory.as<StrategyFollowingMemory>().strategy.under_way) {
    return BoundaryFollowing::start(input, way, blocking, state);
  }
  if (blocking < 0) return;
  state.deviation.active = true;
  follow_in_strategy(input, way, state);
}

void StrategyFollowing::renew(const MethodInput& input, const JointVector& way, MethodState state) const {
  StrategyMemory& strategy = state.memory.as<StrategyFollowingMemory>().strategy;
  if (!strategy.under_way) return BoundaryFollowing::renew(input, way, state);
  strategy.side = -strategy.side;  // behaviour 3: change local direction
  follow_in_strategy(input, way, state);
}

std::unique_ptr<MethodWorkspace> StrategyStep::make_workspace(const CellGeometry& geometry) const {
  return std::make_unique<StepWorkspace>(geometry);
}

WantedMotion StrategyStep::want(const MethodInput& input, MethodState state) const {
  if (input.scene == nullptr || input.scene->workspace == nullptr) return MotionMethod::want(input, state);
  auto& arms = static_cast<StepWorkspace&>(*input.scene->workspace).arms;
  const JointVector way_point =
      step_way_point(parameters, input, *input.scene, arms, state.memory.as<StrategyMemory>());
  return {goal_velocity(input.limits, input.q, way_point, input.dt)};
}

}  // namespace hecaton::planner
