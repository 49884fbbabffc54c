#pragma once
/// The motion methods of [Mediavilla02] for a live arm: avoidance in the plane of a motion strategy
/// (docs/explanation/strategies.md).

#include <span>

#include "planner/methods/boundary_following/boundary_following.hpp"
#include "planner/methods/motion_method.hpp"
#include "planner/methods/strategy/strategy.hpp"

namespace hecaton::planner {

/// The present target of an arm by the step rule [Mediavilla02, section 4]: the end of the last step. The next step
/// follows when the arm is near this target. A configuration is free if it is within limits, at least h from all
/// present arms and obstacles, and free of self-collision. `arms`: scratch, one per arm of the cell.
///
/// differs from paper: the arm moves to the target under dampers, velocity and acceleration limits. Joints that do not
/// avoid move straight to the goal. If the target is no longer free, the arm decides again from its present position.
[[nodiscard]] JointVector step_way_point(const StrategyParameters& parameters, const MethodInput& input,
                                         const MethodScene& scene, std::span<Kinematics> arms, StrategyMemory& memory);

/// Parameters of both methods, and the check that they suit an arm.
class StrategyKeys : public Configured<StrategyParameters> {
 protected:
  void visit(ParameterVisitor& visitor);
  [[nodiscard]] std::optional<std::string> unfit(const RobotModel& robot) const;
};

/// Boundary following in the plane of the strategy.
class StrategyFollowing final : public BoundaryFollowing, public StrategyKeys {
 public:
  StrategyFollowing()
      : BoundaryFollowing({.name = "strategy", .summary = "boundary following in the plane of a motion strategy"}) {}

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

/// The published on-line stage: steps to free neighbours in the plane.
class StrategyStep final : public MotionMethod, public StrategyKeys {
 public:
  StrategyStep()
      : MotionMethod({.name = "strategy_step", .summary = "the published steps in the plane of a motion strategy"}) {}

  void visit_parameters(ParameterVisitor& visitor) override { visit(visitor); }
  [[nodiscard]] std::optional<std::string> objection(const Arm& arm,
                                                     std::span<const RangeSensor> /*sensors*/) const override {
    return unfit(*arm.model);
  }
  /// No step leads nearer to other bodies than h.
  [[nodiscard]] std::optional<double> least_rest_distance() const override { return parameters.distance + 1e-3; }
  [[nodiscard]] std::unique_ptr<MethodWorkspace> make_workspace(const CellGeometry& geometry) const override;
  [[nodiscard]] WantedMotion want(const MethodInput& input, MethodState state) const override;
  void prepare(MethodMemory& memory) const override { static_cast<void>(memory.as<StrategyMemory>()); }
};

}  // namespace hecaton::planner
