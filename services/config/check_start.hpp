#pragma once
/// Whether a cell can come up: nothing overlaps where everything stands at the start.

#include <string>

#include "planner/cell.hpp"

namespace hecaton::config {

/// Throws ConfigError, naming both bodies and the depth, when
/// - the parts of two arms that no joint moves overlap,
/// - an arm in its start or in any of its named poses touches itself,
/// - at the start an arm touches another arm, or one of its moving parts an obstacle,
/// - at a stop of the cell's route, where all arms stand at once, an arm touches another, or one of its moving parts an
///   obstacle that stands.
/// `file` is named in the messages.
void check_start(const planner::Cell& cell, const std::string& file);

/// Where an obstacle that is not attached is at t = 0, its motion included.
[[nodiscard]] world::Pose initial_pose(const world::Obstacle& obstacle);

}  // namespace hecaton::config
