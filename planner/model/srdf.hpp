#pragma once
/// SRDF, MoveIt's semantic robot description: link pairs that need no check, and named configurations.

#include <string>

#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// Removes the pairs that the SRDF at `path` disables from model.self_pairs (disable_collisions, and
/// disable_default_collisions without enable_collisions). Adds group_states that set every joint within its limits to
/// model.named. Skips entries with unknown links or joints, with a note. Throws ModelError when the file is no SRDF.
void apply_srdf(const std::string& path, RobotModel& model, SourceFiles& sources);

}  // namespace hecaton::planner
