#pragma once
/// Fewer links for robots with many fixed frames, such as humanoids.

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// Merges links that are fixed to their parent into that parent until the model has at most `most` links. Links without
/// geometry beside the way to the tool go first. Links with geometry beside it follow, then those on the way, each time
/// from the last one on. The tool link stays. Adds a note if links disappear.
void merge_fixed_links(int most, RobotModel& model);

}  // namespace hecaton::planner
