#pragma once
/// The signed distance between two placed shapes, whoever computes it.

#include <Eigen/Core>

namespace hecaton::planner {

struct ShapeDistance {
  double distance = 0.0;                            ///< [m]; negative: depth of penetration
  Eigen::Vector3d p_a_W = Eigen::Vector3d::Zero();  ///< nearest (or deepest) point on a [m]
  Eigen::Vector3d p_b_W = Eigen::Vector3d::Zero();  ///< nearest (or deepest) point on b [m]
  /// Unit, from a towards b: moving a along −n increases the distance. p_b_W = p_a_W + distance · n_W.
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
};

/// The same distance with a and b exchanged.
inline ShapeDistance exchanged(const ShapeDistance& ab) {
  return {ab.distance, ab.p_b_W, ab.p_a_W, -ab.n_W};
}

/// Distance of the shapes that balls of radius_a and radius_b [m] sweep along a and b. Exact as long as `cores` is: a
/// ball adds its radius to a support function in every direction.
inline ShapeDistance swept(const ShapeDistance& cores, double radius_a, double radius_b) {
  return {cores.distance - radius_a - radius_b, cores.p_a_W + radius_a * cores.n_W, cores.p_b_W - radius_b * cores.n_W,
          cores.n_W};
}

}  // namespace hecaton::planner
