#pragma once
/// What the cell file promises: the nodes that must be heard, and how soon silence counts.

#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/failover/planner_failover.hpp"

namespace hecaton::services {

[[nodiscard]] std::vector<std::string> arm_names(const config::CellFile& file);

/// Agents of all hosts that have work, the world, of each arm its driver and planners, and the supervisors but `self`.
[[nodiscard]] std::vector<ExpectedNode> expected_nodes(const config::CellFile& file, const std::string& self);

/// The arms that have a standby.
[[nodiscard]] std::vector<ArmPlanners> arms_with_standby(const config::CellFile& file);

/// How long an arm moves on at most after its last state was heard before it begins to brake [s]
/// (docs/design/0009-lost-arms.md): when its driver has died, and when its host was cut off.
[[nodiscard]] double longest_motion_of_dead(const config::CellFile& file);
[[nodiscard]] double longest_motion_of_cut_off(const config::CellFile& file);

/// `loop_period`: of the supervisor.
[[nodiscard]] DetectionLimits detection_limits(const config::CellFile& file, Time loop_period);

}  // namespace hecaton::services
