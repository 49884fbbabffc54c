#include "services/config/method_rules.hpp"

#include "planner/cspace/arm_planes.hpp"

namespace hecaton::config {
namespace {

/// Of a full turn. A map in space has as many planes, and takes nine bytes for each of its cells: 62 MB for a PUMA.
constexpr int kMostCellsInSpace = 240;

}  // namespace

std::string complain_about_method(const planner::PlannedArm& planned) {
  if (!planned.parameters.by_cspace()) return {};
  const bool senses = planned.parameters.method == planner::Method::kSensedCspace;
  const std::string method = senses ? "sensed_cspace" : "known_cspace";
  const planner::RobotModel& robot = *planned.arm.model;
  const std::string objection = planner::cspace::ArmPlanes::why_not(robot);
  if (!objection.empty()) {
    return method +
           " must be given to an arm of two links that turn in a plane, which a joint may turn about the base; "
           "of robot " +
           robot.name + ", " + objection;
  }
  const int cells = planned.parameters.sensed.cells;
  if (robot.joints() == 3 && cells > kMostCellsInSpace) {
    return method + " must be given to an arm with three joints with sensed.cells of " +
           std::to_string(kMostCellsInSpace) + " at most, not " + std::to_string(cells);
  }
  if (senses && planned.sensors.empty()) return method + " must be given to an arm with sensors";
  return {};
}

}  // namespace hecaton::config
