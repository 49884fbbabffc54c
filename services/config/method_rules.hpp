#pragma once
/// Which methods an arm can be planned by.

#include <string>

#include "planner/cell.hpp"

namespace hecaton::config {

/// Empty when the arm's method suits it; otherwise "sensed_cspace must be …": a way through C-space needs an arm that
/// [Li96] can map, and sensors where it is told nothing.
[[nodiscard]] std::string complain_about_method(const planner::PlannedArm& planned);

}  // namespace hecaton::config
