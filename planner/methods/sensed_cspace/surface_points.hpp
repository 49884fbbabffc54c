#pragma once
/// What an arm sees of an obstacle that it knows.

#include <vector>

#include "world/model/scene.hpp"

namespace hecaton::planner::cspace {

/// Points on the surfaces of the obstacle's shapes, where it is at t = 0: none of the surface is farther than `spacing`
/// from the nearest of them. In W [m]. None of what an arm carries.
[[nodiscard]] std::vector<Eigen::Vector3d> surface_points(const world::Obstacle& obstacle, double spacing);

}  // namespace hecaton::planner::cspace
