#pragma once
/// What a planner knows of the arms of the cell.

#include <cstdint>
#include <memory>
#include <vector>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// What the arm that proposes it publishes.
struct CoupledPlan {
  std::uint32_t number = 0;                      ///< of this proposer; grows
  std::vector<int> arms;                         ///< that it moves, as indices in the cell, ascending
  std::vector<std::vector<JointVector>> points;  ///< of each of these arms, in their order: about where they were, …,
                                                 ///< their goals [rad | m]
};

/// What every arm publishes.
struct CoupledPlanProgress {
  int proposer = -1;         ///< of the plan that the arm has joined; −1: none
  std::uint32_t number = 0;  ///< of that plan
  int reached = -1;          ///< the last of its points that the arm was near to; −1: it has joined

  bool operator==(const CoupledPlanProgress&) const = default;
  [[nodiscard]] bool of(int plan_proposer, std::uint32_t plan_number) const {
    return proposer == plan_proposer && number == plan_number;
  }
};

/// What the own arm does to follow the planner.
struct MeasuredState {
  JointVector q;   ///< [rad | m]
  JointVector qd;  ///< [rad/s | m/s]
};

/// State of another arm. Index = index in the cell; the entry of the own arm is ignored. An arm that was lost is at
/// rest, of age 0, and its state is a region (planner/local/latency_compensation.hpp).
struct ArmObservation {
  JointVector q;               ///< [rad | m]
  JointVector qd;              ///< [rad/s | m/s]
  double age = 0.0;            ///< since it was true, on this planner's clock [s], ≥ 0
  bool known = false;          ///< ever heard of; an arm that was never heard of stops this one
  bool plans = false;          ///< takes its half of the damper (eq. 8); false: held, stopped or without planner
  bool has_goal = false;       ///< known to be under way to q_goal, where it has not been yet
  JointVector q_goal = {};     ///< [rad | m]
  std::uint32_t priority = 0;  ///< in the right of way (planner/local/right_of_way.hpp)
  JointVector position_uncertainty = {};  ///< every joint is within this of q, either way; empty: q is exact [rad | m]
  CoupledPlanProgress progress = {};      ///< of the coupled plan that it has joined
  std::shared_ptr<const CoupledPlan> proposal = nullptr;  ///< its own; null: none

  [[nodiscard]] bool lost() const { return position_uncertainty.size() > 0; }
};

}  // namespace hecaton::planner
