#include "planner/methods/potential_field/field_method.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "planner/local/goal_objective.hpp"

namespace hecaton::planner::potential {
namespace {

/// Within this distance the arm moves straight to the goal [rad | m].
constexpr double kHome = 0.1;
/// A total gradient below this share of the attraction's reduces the velocity in proportion.
constexpr double kCalm = 0.5;

}  // namespace

JointVector field_velocity(const JointLimits& limits, const FieldValue& field, const JointVector& q,
                           const JointVector& q_goal, double dt) {
  const double distance = joint_difference(limits, q, q_goal).norm();
  const double slope = field.gradient.norm();
  if (distance < kHome) return goal_velocity(limits, q, q_goal, dt);
  const JointVector down = steepest_descent(field);
  const double length = down.norm();
  if (length <= 0.0) return JointVector::Zero(q.size());
  const double calm = std::min(1.0, slope / (kCalm * field.attraction_gradient.norm() + 1e-12));
  const JointVector ahead = q + distance / length * down;
  return calm * goal_velocity(limits, q, ahead, dt);
}

namespace {

/// Window [s] and least travel [rad | m] of the oscillation monitor.
constexpr double kOscillationWindow = 1.0;
constexpr double kLeastOscillation = 0.02;

struct FieldWorkspace final : MethodWorkspace {
  FieldWorkspace(const CellGeometry& geometry, const PotentialParameters& parameters) : field(geometry, parameters) {}
  void rebuild(const CellGeometry& geometry) override { field.rebuild(geometry); }

  PotentialField field;
  FieldValue value;
};

}  // namespace

void FieldMethod::visit_parameters(ParameterVisitor& visitor) {
  static constexpr std::array<std::string_view, 2> kAttractions = {"control_points", "joints"};
  visitor.section("potential");
  visitor.choice("attraction", kAttractions, parameters.attraction);
  visitor.number("goal_distance", parameters.goal_distance, {0.0, 10.0, "m or rad", true});
  visitor.number("repulsion", parameters.repulsion, {0.0, 10.0, "m⁴", true});
  visitor.number("influence_distance", parameters.influence_distance, {0.0, 10.0, "m", true});
  visitor.number("spacing", parameters.spacing, {0.005, 10.0, "m"});
}

std::optional<std::string> FieldMethod::validate() const {
  const struct {
    const char* key;
    double value;
  } positives[] = {{"potential.goal_distance", parameters.goal_distance},
                   {"potential.repulsion", parameters.repulsion},
                   {"potential.influence_distance", parameters.influence_distance},
                   {"potential.spacing", parameters.spacing}};
  for (const auto& [key, value] : positives) {
    if (!std::isfinite(value) || value <= 0.0) return must_be(key, value, "a finite number above 0");
  }
  return std::nullopt;
}

std::unique_ptr<MethodWorkspace> FieldMethod::make_workspace(const CellGeometry& geometry) const {
  return std::make_unique<FieldWorkspace>(geometry, parameters);
}

WantedMotion FieldMethod::want(const MethodInput& input, MethodState state) const {
  if (input.scene == nullptr || input.scene->workspace == nullptr) return MotionMethod::want(input, state);
  auto& [field, value] = static_cast<FieldWorkspace&>(*input.scene->workspace);
  field.set_goal(input.q_goal);
  field.evaluate(input.scene->poses, input.q, value);
  auto& oscillation = state.memory.as<OscillationMonitor>();
  oscillation.observe(input.q, input.dt, kOscillationWindow, kLeastOscillation);
  return {field_velocity(input.limits, value, input.q, input.q_goal, input.dt), oscillation.oscillating};
}

}  // namespace hecaton::planner::potential
