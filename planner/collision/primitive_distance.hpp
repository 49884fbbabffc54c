#pragma once
/// Signed distances between segments (points are segments of length 0), boxes and cylinders. Those in closed form are
/// exact up to rounding, also in penetration. None allocates.

#include <optional>

#include "planner/collision/clearance.hpp"
#include "world/model/pose.hpp"

namespace hecaton::planner {

struct Segment {
  Eigen::Vector3d p_W;  ///< one end [m]
  Eigen::Vector3d q_W;  ///< the other end [m], may be the same
};

/// Below this distance [m] the direction between two nearest points is rounding noise: the direction of least
/// penetration takes its place.
inline constexpr double kTouching = 1e-8;

/// a: segment, b: segment. Never negative: segments have no inside.
[[nodiscard]] ShapeDistance segment_segment(const Segment& a, const Segment& b);

/// a: segment, b: box of `half_extents` [m] around the origin of S.
[[nodiscard]] ShapeDistance segment_box(const Segment& a, const Eigen::Vector3d& half_extents, const world::Pose& X_WS);

/// a: point, b: cylinder of `radius` and `half_length` [m] along z of S.
[[nodiscard]] ShapeDistance point_cylinder(const Eigen::Vector3d& p_W, double radius, double half_length,
                                           const world::Pose& X_WS);

/// a: segment, b: cylinder of `radius` and `half_length` [m] along z of S. The distance is what the normal proves, and
/// at most 1e-9 m below the true one. Empty when they overlap or are nearer than `least` [m].
[[nodiscard]] std::optional<ShapeDistance> segment_cylinder_apart(const Segment& a, double radius, double half_length,
                                                                  const world::Pose& X_WS, double least);

}  // namespace hecaton::planner
