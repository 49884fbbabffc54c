#pragma once
/// What the supervisor tells of the cell: its status, why each arm stands still, and which arms are lost.

#include <string>
#include <vector>

#include <idl/supervisor.h>

#include "services/config/cell_file.hpp"
#include "services/supervisor/cell_snapshot.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/failover/planner_failover.hpp"
#include "services/supervisor/messages.hpp"

namespace hecaton::services {

struct StatusSource {
  const config::CellFile& file;
  const FaultDetector& watch;
  const CellSnapshot& snapshot;
  const PlannerFailover& failover;
  const msg::CellMode& mode;  ///< as last published
};
/// `uptime` is left to the caller.
[[nodiscard]] msg::CellStatus cell_status(const StatusSource& source, const Clocks& clocks);

/// Why an arm stands still: the first of the reasons, from the strictest down. CAUSE_NONE while it moves.
[[nodiscard]] msg::Cause waiting_for(const std::string& arm, const FaultDetector& watch, const CellSnapshot& snapshot);
/// "blocked: no way for now (arm2/link4 – pallet, 18 mm)"
[[nodiscard]] std::string goal_text(const msg::GoalStatus& goal);

/// The arms that are lost and at rest: others may work around them.
[[nodiscard]] std::vector<msg::LostArm> lost_arms(const config::CellFile& file, const FaultDetector& watch,
                                                  const CellSnapshot& snapshot, bus::Clock::time_point now);

}  // namespace hecaton::services
