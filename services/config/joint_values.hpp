#pragma once
/// Numbers of a cell file that belong to the joints of an arm.

#include "planner/model/robot_model.hpp"
#include "services/config/arm_view.hpp"

namespace hecaton::config {

/// The URDF's limits, tightened by what the arm's `limits` say.
[[nodiscard]] planner::JointLimits read_limits(const ArmView& arm, const planner::RobotModel& model);

/// One position per joint, each within `limits`.
[[nodiscard]] planner::JointVector read_configuration(const YamlView& view, const planner::RobotModel& model,
                                                      const planner::JointLimits& limits);

}  // namespace hecaton::config
