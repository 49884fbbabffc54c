#pragma once
/// A point cloud for Bullet: its balls, and a broad phase over them. It shares no search with the planner.

#include <memory>
#include <optional>

#include "world/model/shape.hpp"
#include "world/sim/bullet_shape.hpp"
#include "world/sim/shape_tree.hpp"

namespace hecaton::world {

/// Two readers may query it at the same time.
class CloudBalls {
 public:
  explicit CloudBalls(std::shared_ptr<const PointCloud> cloud);

  /// Signed distance of the convex shape a from the ball that is nearest, or the deepest. The cloud is placed at X_WS.
  [[nodiscard]] SignedDistance distance_from(const btConvexShape& a, const btTransform& X_WA,
                                             const btTransform& X_WS) const;
  /// Distance [m] from p_S along the unit vector d_S, both in the cloud's frame, to the first ball; 0 inside one; empty
  /// when there is none within `range` [m].
  [[nodiscard]] std::optional<double> cast(const Eigen::Vector3d& p_S, const Eigen::Vector3d& d_S, double range) const;

 private:
  std::shared_ptr<const PointCloud> cloud_;
  btSphereShape ball_;
  ShapeTree tree_;  ///< of the balls, in the cloud's frame
};

/// The balls of a cloud. The users of one cloud share them, because building takes a while. Thread-safe.
[[nodiscard]] std::shared_ptr<const CloudBalls> cloud_balls(const std::shared_ptr<const PointCloud>& cloud);

}  // namespace hecaton::world
