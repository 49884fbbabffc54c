#pragma once
/// The geometric checks of validate(), in check_geometry.cpp. Each appends its findings.

#include <string>
#include <utility>
#include <vector>

#include "planner/model/arm.hpp"
#include "services/config/validate.hpp"

namespace hecaton::config {

using Findings = std::vector<Finding>;

inline void warn(Findings& findings, std::string sentence) {
  findings.push_back({Severity::kWarning, std::move(sentence)});
}

/// Named poses, starts and stops of the pose sequence at which dampers keep an arm away.
void check_clearances(const planner::Cell& cell, Findings& findings);
/// Scripted obstacles that pass through an arm's base, are faster than an arm, accelerate more than arms assume, or
/// jump within reach.
void check_obstacles(const planner::Cell& cell, Findings& findings);

/// "arms[2]"
[[nodiscard]] std::string arm_key(int arm);

/// The largest speed [m/s] of the tool frame's origin over random configurations and all joint velocities within the
/// limits: a tight lower bound of the maximum. Deterministic.
[[nodiscard]] double top_tool_speed(const planner::Arm& arm);

}  // namespace hecaton::config
