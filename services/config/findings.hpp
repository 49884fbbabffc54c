#pragma once
/// The single checks of validate(); each appends its findings.

#include <vector>

#include "services/config/validate.hpp"

namespace hecaton::config {

using Findings = std::vector<Finding>;

/// Dampers against latency and against what braking can follow.
void check_dampers(const planner::Cell& cell, Findings& findings);
/// Named poses, starts and stops of the route that the dampers do not let the arm keep.
void check_clearances(const planner::Cell& cell, Findings& findings);
/// Obstacles that run through an arm's base or faster than an arm can flee.
void check_obstacles(const planner::Cell& cell, Findings& findings);
/// Margins of arms that sense against what is between beams, and their noise.
void check_sensors(const planner::Cell& cell, Findings& findings);
/// How much of the task area each arm reaches.
void check_reach(const planner::Cell& cell, Findings& findings);

/// "arms[2]"
[[nodiscard]] std::string arm_key(int arm);

}  // namespace hecaton::config
