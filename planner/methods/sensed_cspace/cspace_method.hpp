#pragma once
/// The motion methods of [Li96]: a path through C-space, searched in what the arm has sensed, or in all obstacles.
/// docs/design/0011-sensed-cspace.md.

#include <vector>

#include "planner/methods/motion_method.hpp"
#include "planner/methods/sensed_cspace/sensed_map.hpp"
#include "world/model/scene.hpp"

namespace hecaton::planner::cspace {

/// Points on the surfaces of the obstacle's shapes, where it is at t = 0: none of the surface is farther than `spacing`
/// from the nearest of them. In W [m]. None of what an arm carries.
[[nodiscard]] std::vector<Eigen::Vector3d> surface_points(const world::Obstacle& obstacle, double spacing);

class CspaceMethod : public MotionMethod, public Configured<SensedParameters> {
 public:
  void visit_parameters(ParameterVisitor& visitor) override;
  [[nodiscard]] std::optional<std::string> validate() const override;
  [[nodiscard]] std::optional<std::string> objection(const Arm& arm,
                                                     std::span<const RangeSensor> sensors) const override;

 protected:
  using MotionMethod::MotionMethod;
};

/// The arm knows no obstacle but what its own sensors see.
class SensedCspace final : public CspaceMethod {
 public:
  SensedCspace()
      : CspaceMethod({.name = "sensed_cspace",
                      .summary = "a way through what the arm's own sensors leave free in C-space",
                      .sensor_only = true,
                      .path = MethodTraits::Path::kWalk,
                      .plot = MethodTraits::Plot::kCspace}) {}

  [[nodiscard]] std::optional<SensingMargin> sensing_margin() const override {
    return SensingMargin{"sensed.margin", parameters.margin};
  }
  [[nodiscard]] std::unique_ptr<MotionGuide> make_guide(const Arm& arm, double dt) const override;
};

/// The same for an arm that is told all obstacles, which must stand still: what sensing costs, by comparison.
class KnownCspace final : public CspaceMethod {
 public:
  KnownCspace()
      : CspaceMethod({.name = "known_cspace",
                      .summary = "a way through C-space past all obstacles, which stand still",
                      .path = MethodTraits::Path::kWalk,
                      .plot = MethodTraits::Plot::kCspace}) {}

  [[nodiscard]] std::unique_ptr<MotionGuide> make_guide(const Arm& arm, double dt) const override;
};

}  // namespace hecaton::planner::cspace
