#include "services/config/method_rules.hpp"

#include "planner/cspace/arm_planes.hpp"

namespace hecaton::config {
namespace {

/// Of a full turn. A map in space has as many planes, and takes nine bytes for each of its cells: 62 MB for a PUMA.
constexpr int kMostCellsInSpace = 240;

std::string complain_about_strategy(const planner::PlannedArm& planned) {
  const planner::Method method = planned.parameters.method;
  if (method != planner::Method::kStrategy && method != planner::Method::kStrategyStep) return {};
  const planner::StrategyParameters& strategy = planned.parameters.strategy;
  const std::string name = method == planner::Method::kStrategy ? "strategy" : "strategy_step";
  const int joints = planned.arm.model->joints();
  const int avoiding = planner::avoiding_joints(strategy, joints);
  if (joints < 2 || avoiding > joints) {
    return name + " must be given to an arm with two joints at least, and as many as strategy.joints says; robot " +
           planned.arm.model->name + " has " + std::to_string(joints);
  }
  if (strategy.coefficients != avoiding - 2) {
    return name + " must be given with strategy.coefficients of " + std::to_string(avoiding - 2) +
           " numbers, two fewer than joints that avoid, not " + std::to_string(strategy.coefficients);
  }
  return {};
}

}  // namespace

std::string complain_about_method(const planner::PlannedArm& planned) {
  if (std::string complaint = complain_about_strategy(planned); !complaint.empty()) return complaint;
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
