#pragma once
/// One linear constraint on the joint velocity: g · q̇ ≤ h.

#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

struct Row {
  JointVector g;            ///< [m/rad | m/m]: approach speed per joint rate
  double h = 0.0;           ///< [m/s]
  std::uint32_t key = 0;    ///< names the pair of bodies from tick to tick
  bool influences = false;  ///< the pair is nearer than dᵢ: boundary following looks at it
  int arm = -1;             ///< index of the arm that the other body belongs to; −1: it is no other arm's
  int clearance = -1;       ///< index of the clearance it came from
  double stop_time = 0.0;   ///< the damper can be kept while stops take no longer than this [s]
};

}  // namespace hecaton::planner
