#include "planner/methods/sensed_cspace/cspace_method.hpp"

#include <array>
#include <cmath>

#include "planner/methods/sensed_cspace/arm_planes.hpp"
#include "planner/methods/sensed_cspace/sensed_planner.hpp"
#include "planner/methods/sensed_cspace/surface_points.hpp"

namespace hecaton::planner::cspace {
namespace {

/// Of a full turn. A map in space has as many planes, and takes nine bytes for each of its cells: 62 MB for a PUMA.
constexpr int kMostCellsInSpace = 240;

/// Sees the surfaces of what it is told, and never forgets them.
class ToldPlanner final : public SensedPlanner {
 public:
  ToldPlanner(const Arm& arm, const SensedParameters& parameters, double dt)
      : SensedPlanner(arm, parameters, dt), spacing_(parameters.margin) {}

  void set_obstacles(std::span<const world::Obstacle> obstacles) override {
    for (const world::Obstacle& obstacle : obstacles) {
      for (const auto& p_W : surface_points(obstacle, spacing_)) see(p_W);
    }
  }
  void sense(const RangeScan& /*scan*/) override {}

 private:
  double spacing_;  ///< [m]
};

}  // namespace

void CspaceMethod::visit_parameters(ParameterVisitor& visitor) {
  static constexpr std::array<std::string_view, 3> kRemember = {"never", "until_nearer", "always"};
  visitor.section("sensed");
  visitor.integer("cells", parameters.cells, 36, 1440);
  visitor.number("margin", parameters.margin, {0.0, 1.0, "m", true});
  visitor.choice("remember", kRemember, parameters.remember);
}

std::optional<std::string> CspaceMethod::validate() const {
  const auto& [cells, margin, remember] = parameters;
  if (cells < 36 || cells > 1440 || cells % 4 != 0) {
    return must_be("sensed.cells", cells, "a multiple of 4 from 36 to 1440");
  }
  if (!std::isfinite(margin) || margin <= 0.0) return must_be("sensed.margin", margin, "a finite number above 0");
  return std::nullopt;
}

std::optional<std::string> CspaceMethod::objection(const Arm& arm, std::span<const RangeSensor> sensors) const {
  const RobotModel& robot = *arm.model;
  if (const auto why = ArmPlanes::why_not(robot)) {
    return "must be given to an arm of two links that turn in a plane, which a joint may turn about the base; of "
           "robot " +
           robot.name + ", " + *why;
  }
  if (robot.joints() == 3 && parameters.cells > kMostCellsInSpace) {
    return "must be given to an arm with three joints with sensed.cells of " + std::to_string(kMostCellsInSpace) +
           " at most, not " + std::to_string(parameters.cells);
  }
  if (traits().sensor_only && sensors.empty()) return "must be given to an arm with sensors";
  return std::nullopt;
}

std::unique_ptr<MotionGuide> SensedCspace::make_guide(const Arm& arm, double dt) const {
  return std::make_unique<SensedPlanner>(arm, parameters, dt);
}

std::unique_ptr<MotionGuide> KnownCspace::make_guide(const Arm& arm, double dt) const {
  return std::make_unique<ToldPlanner>(arm, parameters, dt);
}

}  // namespace hecaton::planner::cspace
