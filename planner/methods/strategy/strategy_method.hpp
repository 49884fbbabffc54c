#pragma once
/// The motion methods of [Mediavilla02] for a live arm: avoidance in the plane that a motion strategy chose
/// (docs/strategies.md).

#include <span>

#include "planner/methods/boundary_following/boundary_following.hpp"
#include "planner/methods/motion_method.hpp"
#include "planner/methods/strategy/strategy.hpp"

namespace hecaton::planner {

/// Where the arm goes now: the configuration that the last step of [Mediavilla02, section 4] led to; a new step is
/// taken where the arm is nearly there. A configuration is free if it is within limits, at least h from all arms and
/// obstacles as they are now, and clear of itself.
///
/// differs from paper: the arm does not jump there but moves, under dampers, velocity and acceleration limits; joints
/// that do not avoid go straight to the goal; and when what it goes to is no longer free, it decides anew from where it
/// is. `arms`: scratch, one per arm of the cell.
[[nodiscard]] JointVector step_way_point(const StrategyParameters& parameters, const MethodInput& input,
                                         const MethodScene& scene, std::span<Kinematics> arms, StrategyMemory& memory);

/// The parameters that both have, and whether they suit an arm.
class StrategyKeys : public Configured<StrategyParameters> {
 protected:
  void visit(ParameterVisitor& visitor);
  [[nodiscard]] std::optional<std::string> unfit(const RobotModel& robot) const;
};

/// Under constraints, and where they leave nothing of the way along the boundary, in the strategy's plane.
class StrategyFollowing final : public BoundaryFollowing, public StrategyKeys {
 public:
  StrategyFollowing()
      : BoundaryFollowing({.name = "strategy", .summary = "around in the plane that a motion strategy chose"}) {}

  void visit_parameters(ParameterVisitor& visitor) override;
  [[nodiscard]] std::optional<std::string> objection(const Arm& arm,
                                                     std::span<const RangeSensor> /*sensors*/) const override {
    return unfit(*arm.model);
  }
  [[nodiscard]] Redirection redirect(const MethodInput& input, const ConstrainedMotion& constrained,
                                     MethodState state) const override;

 protected:
  void start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const override;
  void renew(const MethodInput& input, const JointVector& way, MethodState state) const override;
  [[nodiscard]] FollowerMemory& follower_of(MethodMemory& memory) const override;
};

/// The on-line stage as published: steps to free neighbours in that plane.
class StrategyStep final : public MotionMethod, public StrategyKeys {
 public:
  StrategyStep() : MotionMethod({.name = "strategy_step", .summary = "the published steps in that plane"}) {}

  void visit_parameters(ParameterVisitor& visitor) override { visit(visitor); }
  [[nodiscard]] std::optional<std::string> objection(const Arm& arm,
                                                     std::span<const RangeSensor> /*sensors*/) const override {
    return unfit(*arm.model);
  }
  /// No step leads nearer to anything than h.
  [[nodiscard]] std::optional<double> least_rest_distance() const override { return parameters.distance + 1e-3; }
  [[nodiscard]] std::unique_ptr<MethodWorkspace> make_workspace(const CellGeometry& geometry) const override;
  [[nodiscard]] WantedMotion want(const MethodInput& input, MethodState state) const override;
};

}  // namespace hecaton::planner
