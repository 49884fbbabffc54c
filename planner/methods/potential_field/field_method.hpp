#pragma once
/// The motion method of [Cardenas10]: down the gradient of artificial potentials, under the local planner's
/// constraints.

#include "planner/methods/potential_field/oscillation_monitor.hpp"
#include "planner/methods/potential_field/potential_field.hpp"
#include "planner/model/limits.hpp"

namespace hecaton::planner::potential {

/// The joint velocity down the gradient [rad/s | m/s]. It is as large as the limits allow, smaller where repulsion
/// nearly cancels attraction, and in time to stop at the goal. Near the goal the velocity points straight to it,
/// because an obstacle near the goal shifts the minimum of the field. differs from paper: the field gives the direction
/// only; the local planner keeps limits and distances (docs/explanation/potential-fields.md).
[[nodiscard]] JointVector field_velocity(const JointLimits& limits, const FieldValue& field, const JointVector& q,
                                         const JointVector& q_goal, double dt);

class FieldMethod final : public MotionMethod, public Configured<PotentialParameters> {
 public:
  FieldMethod()
      : MotionMethod({.name = "potential_field",
                      .summary = "down the gradient of artificial potentials",
                      .path = MethodTraits::Path::kDescent,
                      .plot = MethodTraits::Plot::kField}) {}

  void visit_parameters(ParameterVisitor& visitor) override;
  [[nodiscard]] std::optional<std::string> validate() const override;
  [[nodiscard]] std::unique_ptr<MethodWorkspace> make_workspace(const CellGeometry& geometry) const override;
  [[nodiscard]] WantedMotion want(const MethodInput& input, MethodState state) const override;
  void prepare(MethodMemory& memory) const override { static_cast<void>(memory.as<OscillationMonitor>()); }
};

}  // namespace hecaton::planner::potential
