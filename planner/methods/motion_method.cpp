#include "planner/methods/motion_method.hpp"

#include <algorithm>

#include "planner/local/goal_objective.hpp"

namespace hecaton::planner {
namespace {

/// An arm counts as blocked below this share of its wanted velocity [Lahouar06, section 4].
constexpr double kDeadlockFraction = 0.30;

}  // namespace

std::unique_ptr<MethodWorkspace> MotionMethod::make_workspace(const CellGeometry& /*geometry*/) const {
  return nullptr;
}

std::unique_ptr<MotionGuide> MotionMethod::make_guide(const Arm& /*arm*/, double /*dt*/) const {
  return nullptr;
}

WantedMotion MotionMethod::want(const MethodInput& input, MethodState /*state*/) const {
  return {goal_velocity(input.limits, input.q, input.target, input.dt)};
}

Redirection MotionMethod::redirect(const MethodInput& /*input*/, const ConstrainedMotion& /*constrained*/,
                                   MethodState /*state*/) const {
  return {};
}

bool MotionMethod::is_blocked(const JointVector& possible, const JointVector& wanted) const {
  return deadlocked(possible, wanted, kDeadlockFraction);
}

std::shared_ptr<const MotionMethod> find_method(const MethodSet& methods, std::string_view name) {
  const auto found =
      std::find_if(methods.begin(), methods.end(), [&](const auto& method) { return method->traits().name == name; });
  return found == methods.end() ? nullptr : *found;
}

}  // namespace hecaton::planner
