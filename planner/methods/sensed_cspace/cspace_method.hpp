#pragma once
/// The motion methods of [Li96]: a path through C-space, searched in what the arm has sensed, or in all obstacles.
/// docs/explanation/0011-sensed-cspace.md.

#include <vector>

#include "planner/methods/motion_method.hpp"
#include "planner/methods/sensed_cspace/sensed_map.hpp"
#include "world/model/scene.hpp"

namespace hecaton::planner::cspace {

/// Points on the surfaces of the obstacle's shapes at t = 0, in W [m]. Every point of a surface is within `spacing` [m]
/// of one of them. Empty for carried objects.
[[nodiscard]] std::vector<Eigen::Vector3d> surface_points(const world::Obstacle& obstacle, double spacing);

/// Parameters and checks of both methods.
class CspaceMethod : public MotionMethod, public Configured<SensedParameters> {
 public:
  void visit_parameters(ParameterVisitor& visitor) override;
  [[nodiscard]] std::optional<std::string> validate() const override;
  [[nodiscard]] std::optional<std::string> contact_risk() const override;
  [[nodiscard]] std::optional<std::string> objection(const Arm& arm,
                                                     std::span<const RangeSensor> sensors) const override;

 protected:
  using MotionMethod::MotionMethod;
};

/// The arm knows obstacles from its own sensors only.
class SensedCspace final : public CspaceMethod {
 public:
  SensedCspace()
      : CspaceMethod({.name = "sensed_cspace",
                      .summary = "a path through C-space that the arm's own sensors have not found blocked",
                      .sensor_only = true,
                      .path = MethodTraits::Path::kWalk,
                      .plot = MethodTraits::Plot::kCspace}) {}

  [[nodiscard]] std::optional<SensingMargin> sensing_margin() const override {
    return SensingMargin{"sensed.margin", parameters.margin};
  }
  [[nodiscard]] std::unique_ptr<MotionGuide> make_guide(const Arm& arm, double dt) const override;
};

/// The same for an arm that knows all obstacles, which must be static. Serves as a reference for sensing.
class KnownCspace final : public CspaceMethod {
 public:
  KnownCspace()
      : CspaceMethod({.name = "known_cspace",
                      .summary = "a path through C-space past all obstacles, which must be static",
                      .path = MethodTraits::Path::kWalk,
                      .plot = MethodTraits::Plot::kCspace}) {}

  [[nodiscard]] std::unique_ptr<MotionGuide> make_guide(const Arm& arm, double dt) const override;
};

}  // namespace hecaton::planner::cspace
