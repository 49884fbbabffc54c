#pragma once
/// Example of a motion method: a spring with a damper pulls the arm to its goal.

#include <cmath>

#include "planner/local/goal_objective.hpp"
#include "planner/methods/motion_method.hpp"

namespace example {

namespace hp = hecaton::planner;

struct SpringParameters {
  double stiffness = 4.0;  ///< acceleration towards the goal per distance [1/s²], > 0
  double damping = 1.0;    ///< share of the critical damping, > 0; below 1 the arm overshoots
};

class SpringMethod final : public hp::MotionMethod, public hp::Configured<SpringParameters> {
 public:
  SpringMethod() : MotionMethod({.name = "spring", .summary = "a spring with a damper pulls the arm to its goal"}) {}

  /// Keys of the arm's map `spring` in the cell file.
  void visit_parameters(hp::ParameterVisitor& visitor) override {
    visitor.section("spring");
    visitor.number("stiffness", parameters.stiffness, {0.0, 100.0, "1/s²", true});
    visitor.number("damping", parameters.damping, {0.0, 10.0, "", true});
  }

  /// q̇ after one period of q̈ = k (q_goal − q) − 2 ζ √k q̇. The planner applies the constraints afterwards.
  [[nodiscard]] hp::WantedMotion want(const hp::MethodInput& input, hp::MethodState /*state*/) const override {
    const double k = parameters.stiffness;
    const hp::JointVector error = hp::joint_difference(input.limits, input.q, input.target);
    const hp::JointVector acceleration = k * error - 2.0 * parameters.damping * std::sqrt(k) * input.qd;
    return {input.qd + input.dt * acceleration};
  }
};

}  // namespace example
