#include "planner/methods/strategy/step_rule.hpp"

#include <array>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/goal_objective.hpp"

namespace hecaton::planner {
namespace {

/// Nearer to where it goes than this share of a step, the arm decides on the next: it need not stop in between.
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
    return scene.distance.clearances({&own, arms, scene.poses.obstacles},
                                     {.others = p.distance, .self = scene.self_security_distance}, nearest) == 0;
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

}  // namespace hecaton::planner
