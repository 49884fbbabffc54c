#pragma once
/// What the cell file says about detection: expected nodes, limits of their silence, and motion of arms that are not
/// heard.

#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/failover/planner_failover.hpp"

namespace hecaton::services {

[[nodiscard]] std::vector<std::string> arm_names(const config::CellFile& file);

/// The world, the driver and the planners of each arm, the supervisors except `self`, and the agents of all their
/// hosts.
[[nodiscard]] std::vector<ExpectedNode> expected_nodes(const config::CellFile& file, const std::string& self);

/// The arms that have a standby planner.
[[nodiscard]] std::vector<ArmPlanners> arms_with_standby(const config::CellFile& file);

/// Upper bound of the time from the last received state of an arm until it begins to brake [s]: after its driver died,
/// and after its host was cut off (docs/explanation/0009-lost-arms.md).
[[nodiscard]] double braking_delay_of_dead(const config::CellFile& file);
[[nodiscard]] double braking_delay_of_cut_off(const config::CellFile& file);

/// `loop_period`: of the supervisor's loop.
[[nodiscard]] DetectionLimits detection_limits(const config::CellFile& file, Time loop_period);

}  // namespace hecaton::services
