#pragma once
/// The planners of arms that have a standby: observes them, lets PlannerFailover decide, and tells the detector which
/// planner is in charge.

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
    Time failover_timeout{0};  ///< silence of the planner in charge
    Time host_lease{0};        ///< its silence at the driver; FailoverBackoff extends the failover timeout up to it
  };
  PlannerAssignment(std::vector<ArmPlanners> arms, const Limits& limits, bus::Clock::time_point began);

  /// What it works on in one turn.
  struct Cell {
    const CellSnapshot& snapshot;
    FaultDetector& detector;
    Leadership& leadership;
    bus::Clock::time_point now;  ///< when the turn began
  };
  /// Call it once in each turn. Returns true when it granted a lease, as only a leader does: publish the mode at once.
  bool update(const Cell& cell);
  /// When the silence of a planner in charge will exceed its limit if nothing arrives; never: time_point::max().
  [[nodiscard]] bus::Clock::time_point failover_due(const Cell& cell) const;

  [[nodiscard]] const PlannerFailover& failover() const { return failover_; }
  [[nodiscard]] PlannerFailover& failover() { return failover_; }

 private:
  [[nodiscard]] PlannerObservations observe(const Cell& cell, const std::string& arm, const std::string& planner) const;
  /// Failover timeout of the arm with its backoff.
  [[nodiscard]] Time failover_timeout(const Cell& cell, const std::string& arm) const;

  PlannerFailover failover_;
  Limits limits_;
  bus::Clock::time_point began_;
  std::map<std::string, FailoverBackoff> backoff_;                 ///< by arm
  std::map<std::string, bus::Clock::time_point> in_charge_since_;  ///< of the planner in charge, by arm
};

}  // namespace hecaton::services
