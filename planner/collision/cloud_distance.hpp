#pragma once
/// Exact signed distances between a convex body and the balls of a point cloud.

#include <cmath>
#include <cstddef>
#include <span>

#include "planner/collision/clearance.hpp"
#include "planner/collision/swept_core.hpp"
#include "world/model/point_cloud.hpp"
#include "world/model/pose.hpp"

namespace hecaton::planner {

/// Pairs of one body and one cloud, at most. A convex obstacle has one; a bin around a tool has five.
inline constexpr int kMostBallPairs = 6;

/// A convex body, placed.
struct PlacedBody {
  const SweptCore& core;
  const world::Pose& X_WS;
};

/// The distance of the ball that is nearest, or the deepest. a: the body, b: the ball. The balls must not all be
/// farther than `limit` [m]; otherwise the distance is infinite.
[[nodiscard]] ShapeDistance cloud_distance(const PlacedBody& a, const world::PointCloud& cloud, const world::Pose& X_WP,
                                           double limit);

/// Balls nearer than `limit` [m] that together stand for the cloud as nearest points stand for convex bodies. The
/// nearest ball parts the body from all balls behind the plane between the two. Next comes the nearest ball in front of
/// that plane, and so on. A flat surface gives one ball, a corner one for each side. Returns their number, at most
/// out.size(), nearest first. Does not allocate. The same result on each processor.
[[nodiscard]] int nearest_balls(const PlacedBody& a, const world::PointCloud& cloud, const world::Pose& X_WP,
                                double limit, std::span<ShapeDistance> out);

/// Calls visit(x) for centres x of balls, in the cloud's frame P, until it returns false. Visits all those nearer to
/// the box than `reach` [m], and some others.
template <typename Visit>
bool for_centres_near(const world::PointCloud& cloud, const world::PointBox& box_P, double reach, const Visit& visit,
                      std::size_t node = 0) {
  const world::PointNode& at = cloud.nodes()[node];
  float gaps2[world::kPointFan];
  world::squared_gaps(at, box_P, gaps2);
  for (int k = 0; k < at.count; ++k) {
    if (std::sqrt(static_cast<double>(gaps2[k])) > reach) continue;
    if (at.child[k] >= 0) {
      if (!for_centres_near(cloud, box_P, reach, visit, static_cast<std::size_t>(at.child[k]))) return false;
      continue;
    }
    const world::PointLeaf& leaf = cloud.leaves()[static_cast<std::size_t>(~at.child[k])];
    for (int i = 0; i < leaf.count; ++i) {
      if (!visit(Eigen::Vector3f(leaf.p[0][i], leaf.p[1][i], leaf.p[2][i]))) return false;
    }
  }
  return true;
}

}  // namespace hecaton::planner
