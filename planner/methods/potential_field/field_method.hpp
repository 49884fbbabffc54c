#pragma once
/// The method of [Cardenas10] for a live arm: down the gradient of artificial potentials, under the local planner's
/// constraints.

#include "planner/methods/potential_field/oscillation_monitor.hpp"
#include "planner/methods/potential_field/potential_field.hpp"

namespace hecaton::planner::potential {

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
};

}  // namespace hecaton::planner::potential
