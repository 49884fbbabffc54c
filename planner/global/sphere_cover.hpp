#pragma once
/// Balls that together enclose a shape: what the fast validity check takes for it.

#include <vector>

#include "world/model/shape.hpp"

namespace hecaton::planner::global {

struct CoverOptions {
  double excess = 0.004;  ///< the cover sticks out of the shape by no more than this, where `most` balls suffice [m]
  int most = 48;          ///< balls for one shape
};

/// Every point of the shape lies in one of the balls, which are in the shape's frame S. Balls and capsules are covered
/// in closed form, others by cutting them in halves where a piece's ball sticks out the most.
[[nodiscard]] std::vector<world::BoundingSphere> sphere_cover(const world::Shape& shape, const CoverOptions& options);

/// A ball that encloses the points, at most a few per cent larger than the smallest.
[[nodiscard]] world::BoundingSphere enclosing_ball(const std::vector<Eigen::Vector3d>& points);

}  // namespace hecaton::planner::global
