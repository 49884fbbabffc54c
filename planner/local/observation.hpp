#pragma once
/// What a planner knows of the arms of the cell. Indices of arms are indices in the cell.

#include <cstdint>
#include <memory>
#include <vector>

#include "planner/model/limits.hpp"
#include "planner/model/memory_archive.hpp"

namespace hecaton::planner {

/// A plan for several arms that block each other (docs/explanation/0015-coupled-plans.md). One arm proposes it, other
/// arms join, and all wait for each other at every point. The proposer publishes it.
struct CoupledPlan {
  std::uint32_t number = 0;                      ///< grows with every proposal of this arm
  std::vector<int> arms;                         ///< that it moves, ascending
  std::vector<std::vector<JointVector>> points;  ///< of each of these arms, from near its start to its goal [rad | m]

  void describe(MemoryArchive& archive) {
    archive(number);
    archive.list(arms, [&](int& arm) { archive.index(arm); });
    archive.list(points, [&](std::vector<JointVector>& point) {
      archive.list(point, [&](JointVector& q) { archive.any_joints(q); });
      if (point.size() != arms.size()) archive.fail();
    });
  }
};

/// The progress of an arm in a coupled plan. Every arm publishes its own.
struct CoupledPlanProgress {
  int proposer = -1;         ///< of the plan that the arm has joined; −1: none
  std::uint32_t number = 0;  ///< of that plan
  int reached = -1;          ///< index of the last point that the arm was near; −1: none yet

  bool operator==(const CoupledPlanProgress&) const = default;  ///< member by member
  void describe(MemoryArchive& archive) {
    archive.arm(proposer);
    archive(number);
    archive.count(reached);
  }
  /// The arm has joined this plan.
  [[nodiscard]] bool of(int plan_proposer, std::uint32_t plan_number) const {
    return proposer == plan_proposer && number == plan_number;
  }
};

/// State of the own arm.
struct MeasuredState {
  JointVector q;   ///< [rad | m]
  JointVector qd;  ///< [rad/s | m/s]

  void describe(MemoryArchive& archive) { archive(q, qd); }
};

/// State of another arm; the entry of the own arm is ignored. A lost arm counts as at rest, with age 0, in its
/// reachable stop set (planner/local/latency_compensation.hpp).
struct ArmObservation {
  JointVector q;            ///< [rad | m]
  JointVector qd;           ///< [rad/s | m/s]
  double age = 0.0;         ///< time since this state was measured, on the receiver's clock [s], ≥ 0
  bool known = false;       ///< a state has ever been received; the own arm stops for an unknown arm
  bool plans = false;       ///< true: it keeps its half of the damper (eq. 8); false: held, stopped or without planner
  bool has_goal = false;    ///< it is on its way to q_goal and has not reached it
  JointVector q_goal = {};  ///< [rad | m]
  std::uint32_t priority = 0;             ///< in the right of way (planner/local/right_of_way.hpp)
  JointVector position_uncertainty = {};  ///< half width about q of each joint; empty: q is exact [rad | m]
  CoupledPlanProgress progress = {};      ///< in the coupled plan that it has joined
  std::shared_ptr<const CoupledPlan> proposal = nullptr;  ///< its own proposal; null: none
  double speed = 1.0;    ///< ordered share of its velocity limits, for predictions; no margin may depend on it
  bool foreign = false;  ///< others move it, within its limits: it does not brake or give way, and `plans` is false

  [[nodiscard]] bool lost() const { return position_uncertainty.size() > 0; }  ///< no process reports its position
};

}  // namespace hecaton::planner
