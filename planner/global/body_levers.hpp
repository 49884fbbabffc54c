#pragma once
/// How far joints can move what they carry.

#include <vector>

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::planner::global {

/// For every own body of the geometries, one after the other, and every joint of all their own arms: no point of the
/// body moves farther for a unit of that joint, whatever the others do within their limits [m/rad | 1]. Rounded up.
[[nodiscard]] std::vector<float> body_levers(const std::vector<CellGeometry>& planned);

}  // namespace hecaton::planner::global
