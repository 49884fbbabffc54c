#pragma once
/// What `hecaton check` tells of a robot and of a cell, for people and for programs.

#include <string>
#include <vector>

#include "planner/model/robot_model.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/validate.hpp"

namespace hecaton::services::cli {

/// `limits`: those that hold, which a cell file may have tightened.
[[nodiscard]] Json model_json(const planner::RobotModel& model, const planner::JointLimits& limits);
[[nodiscard]] std::string model_text(const planner::RobotModel& model, const planner::JointLimits& limits,
                                     const Palette& palette);

using Findings = std::vector<config::Finding>;
[[nodiscard]] Json cell_json(const config::CellFile& file, const Findings& findings);
[[nodiscard]] std::string cell_text(const config::CellFile& file, const Findings& findings, const Palette& palette);

/// "box 0.4 × 0.4 × 0.2 m" (full sizes), "convex hull, 24 vertices"
[[nodiscard]] std::string shape_text(const world::Shape& shape);
/// "static", "waypoints", …
[[nodiscard]] std::string motion_text(const world::Motion& motion);

}  // namespace hecaton::services::cli
