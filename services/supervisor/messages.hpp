#pragma once
/// Modes and faults as messages, and what another supervisor's messages tell of them.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <idl/supervisor.h>

#include "services/runtime/stall_compensated_clock.hpp"
#include "services/supervisor/cell_mode.hpp"
#include "services/supervisor/failover/planner_failover.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

/// Relates the watch's time (the steady clock since its epoch) to the wall clock, for people.
struct Clocks {
  Time now{0};
  std::int64_t now_unix_ms = 0;
};
[[nodiscard]] Clocks read_clocks();

/// Term, sequence number and stamp are left to the caller.
[[nodiscard]] msg::CellMode mode_message(const CellModeState& mode, const PlannerFailover& failover,
                                         const std::string& node);
/// Term, sequence number and stamp are left to the caller.
[[nodiscard]] msg::Fault fault_message(const FaultRecord& record, const Clocks& clocks);

/// A fault as another supervisor told it, on our clock, and whose it is, as the watch names it.
struct ToldRecord {
  std::string cause;
  FaultRecord record;
};
/// Empty when it cannot be understood.
[[nodiscard]] std::optional<ToldRecord> told_record(const msg::Fault& fault, const Clocks& clocks);
[[nodiscard]] std::string fault_id(const FaultRecord& record);

/// What asks for these orders; the ids are left to the caller.
[[nodiscard]] std::vector<msg::SupervisorRequest> requests_for(const Orders& orders, const std::string& client);
/// The faults that other leaders told, by id, on our clock. What cannot be understood is left out. A leader tells all
/// that it knows of under its own term: what is open of an earlier one than `term`, the last leader's, is nobody's any
/// more, and over.
[[nodiscard]] FaultHistory faults_in(const std::map<std::string, msg::Fault>& told, std::uint64_t term,
                                     const Clocks& clocks);

}  // namespace hecaton::services
