#pragma once
/// The status of the cell for replies: everything that the supervisor knows, why each arm stands still, and which arms
/// are lost.

#include <string>
#include <vector>

#include <idl/supervisor.h>

#include "services/config/cell_file.hpp"
#include "services/supervisor/cell_publisher.hpp"
#include "services/supervisor/cell_snapshot.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/failover/planner_failover.hpp"

namespace hecaton::services {

struct StatusSource {
  const config::CellFile& file;
  const FaultDetector& detector;
  const CellSnapshot& snapshot;
  const PlannerFailover& failover;
  const msg::CellMode& mode;  ///< as last published
};
/// The caller sets `uptime`.
[[nodiscard]] msg::CellStatus cell_status(const StatusSource& source, const Clocks& clocks);

/// Why an arm stands still: the strictest reason. CAUSE_NONE while it moves.
[[nodiscard]] msg::Cause waiting_for(const std::string& arm, const FaultDetector& detector,
                                     const CellSnapshot& snapshot);
/// Why an arm should move although it stands, as a sentence; empty: it moves, or waits for something. Its goal is under
/// way and nothing holds it, or its driver refuses its planner's commands.
[[nodiscard]] std::optional<std::string> stands_without_reason(const std::string& arm, const FaultDetector& detector,
                                                               const CellSnapshot& snapshot);

/// Lost arms that are at rest by now: other arms plan around them. No reader then has to compute the time since the
/// loss. `stop_without_driver`: of each arm of `file`; one that its controller does not stop is never listed.
[[nodiscard]] std::vector<msg::LostArm> lost_arms(const config::CellFile& file,
                                                  const std::vector<bool>& stop_without_driver,
                                                  const FaultDetector& detector, const CellSnapshot& snapshot,
                                                  bus::Clock::time_point now);

}  // namespace hecaton::services
