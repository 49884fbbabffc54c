#pragma once
/// Reads an arm's distance sensors.

#include <vector>

#include "planner/model/range_sensor.hpp"
#include "planner/model/robot_model.hpp"
#include "services/config/arm_view.hpp"

namespace hecaton::config {

/// None when the arm has no `sensors`. Throws ConfigError.
[[nodiscard]] std::vector<planner::RangeSensor> read_sensors(const ArmView& view, const planner::RobotModel& model);

}  // namespace hecaton::config
