#pragma once
/// Example of an obstacle shape: a cone about the z axis, with its tip on top and half of its height below the origin.

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "planner/model/convex_hull.hpp"
#include "services/config/shape_types.hpp"

namespace example {

namespace world = hecaton::world;

/// `sizes`: radius of the base and height [m]. The base is a regular polygon around the circle, so that the shape
/// encloses the cone. It is at most 1.3 % of the radius larger.
inline world::Shape make_cone(std::span<const double> sizes) {
  constexpr int kSides = 20;
  constexpr double kPi = std::numbers::pi;
  const double corner = sizes[0] / std::cos(kPi / kSides);
  const double half = 0.5 * sizes[1];
  std::vector<Eigen::Vector3d> points = {{0.0, 0.0, half}};
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2.0 * kPi * side / kSides;
    points.emplace_back(corner * std::cos(angle), corner * std::sin(angle), -half);
  }
  return hecaton::planner::convex_shape(points);
}

inline const hecaton::config::ShapeType kCone{
    "cone", "radius of the base and height [m], axis along z", {{"radius"}, {"height"}}, make_cone};

}  // namespace example
