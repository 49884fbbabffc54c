#pragma once
/// The planners of the arms that have a standby: observes them, lets PlannerFailover decide, and tells the detector
/// which of them is in charge.

#include <map>
#include <string>
#include <vector>

#include "services/supervisor/cell_snapshot.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/failover/planner_failover.hpp"

namespace hecaton::services {

class PlannerAssignment {
 public:
  struct Limits {
    Time takeover_lease{0};  ///< a planner in charge may hang so long
    Time host_lease{0};      ///< and be unheard by its driver so long; the takeover lease grows up to it
  };
  PlannerAssignment(std::vector<ArmPlanners> arms, const Limits& limits, bus::Clock::time_point began);

  /// What it works on, in one turn.
  struct Cell {
    const CellSnapshot& snapshot;
    FaultDetector& detector;
    Leadership& leadership;
    bus::Clock::time_point now;  ///< when the turn began
  };
  /// Once in each turn. True when it granted a new lease, as only a leader does: to be published at once.
  bool update(const Cell& cell);
  /// When a planner in charge will have been silent for too long, unless it is heard before; never: time_point::max().
  [[nodiscard]] bus::Clock::time_point takeover_due(const Cell& cell) const;

  [[nodiscard]] const PlannerFailover& failover() const { return failover_; }
  [[nodiscard]] PlannerFailover& failover() { return failover_; }

 private:
  [[nodiscard]] PlannerObservations observe(const Cell& cell, const std::string& arm, const std::string& planner) const;
  /// How long the planner in charge may hang now.
  [[nodiscard]] Time takeover_lease(const Cell& cell, const std::string& arm) const;

  PlannerFailover failover_;
  Limits limits_;
  bus::Clock::time_point began_;
  std::map<std::string, FailoverBackoff> backoff_;                 ///< by arm
  std::map<std::string, bus::Clock::time_point> in_charge_since_;  ///< of the planner in charge, by arm
};

}  // namespace hecaton::services
