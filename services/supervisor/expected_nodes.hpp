#pragma once
/// What the cell file promises: the nodes that must be heard, and how soon silence counts.

#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/supervisor/cell_watch.hpp"

namespace hecaton::services {

[[nodiscard]] std::vector<std::string> arm_names(const config::CellFile& file);

/// Agents of all hosts that have work, the world, and of each arm its driver and planner.
[[nodiscard]] std::vector<ExpectedNode> expected_nodes(const config::CellFile& file);

/// `loop_period`: of the supervisor.
[[nodiscard]] WatchLimits watch_limits(const config::CellFile& file, Time loop_period);

}  // namespace hecaton::services
