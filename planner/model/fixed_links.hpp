#pragma once
/// Fewer links for robots with many fixed frames, such as humanoids.

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// While the model has more than `most` links: merges links that no joint of the chain moves against their parent into
/// that parent: first those beside the way to the tool without geometry, then the others beside it, then those on it,
/// each time from the last one on. The tool link stays. Adds a note if links disappear.
void merge_fixed_links(int most, RobotModel& model);

}  // namespace hecaton::planner
