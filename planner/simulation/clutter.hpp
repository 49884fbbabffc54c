#pragma once
/// Random static obstacles, among which the arms of one episode work.

#include <vector>

#include "planner/cell.hpp"
#include "planner/local/random.hpp"

namespace hecaton::planner {

/// Obstacles of one episode: boxes, spheres and cylinders in a ring around the origin of the cell.
[[nodiscard]] std::vector<world::Obstacle> draw_clutter(const Clutter& clutter, Random& random);

}  // namespace hecaton::planner
