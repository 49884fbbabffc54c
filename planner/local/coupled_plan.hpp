#pragma once
/// A plan for several arms that stand in each other's way: one proposes it, the others join, all wait for each other at
/// every point (docs/design/0015-coupled-plans.md).

#include <cstdint>
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

}  // namespace hecaton::planner
