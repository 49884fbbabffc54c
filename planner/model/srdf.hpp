#pragma once
/// MoveIt's semantic description: which link pairs need no check, and named configurations.

#include <string>

#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// Removes from model.self_pairs what the SRDF at `path` disables (disable_collisions; disable_default_collisions
/// without enable_collisions), and adds its group_states to model.named when they set every joint within its limits.
/// What names unknown links or joints is skipped, with a note. Throws ModelError when the file is no SRDF.
void apply_srdf(const std::string& path, RobotModel& model, SourceFiles& sources);

}  // namespace hecaton::planner
