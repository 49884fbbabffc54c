#pragma once
/// Signed distances with nearest points: between two shapes, and between a body of the own arm and another body.

#include <cstdint>

#include <Eigen/Core>

namespace hecaton::planner {

/// The distance of shapes a and b.
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

/// The distance of the shapes that balls of radius_a and radius_b [m] sweep along the cores a and b. Exact if `cores`
/// is exact, because a ball adds its radius to a support function in every direction.
inline ShapeDistance swept(const ShapeDistance& cores, double radius_a, double radius_b) {
  return {cores.distance - radius_a - radius_b, cores.p_a_W + radius_a * cores.n_W, cores.p_b_W - radius_b * cores.n_W,
          cores.n_W};
}

/// The owner of the other body of a clearance.
enum class Counterpart : std::uint8_t {
  kSelf,      ///< another body of the same arm
  kArm,       ///< a body of another arm
  kObstacle,  ///< a body of an obstacle
};

/// The signed distance between a body of the own arm and another body.
struct Clearance {
  int own_body = 0;  ///< index into CellGeometry::own_bodies()
  int own_link = 0;  ///< the link of the own model to which it is fixed
  Counterpart counterpart = Counterpart::kObstacle;
  int other = 0;          ///< kSelf: the arm itself; kArm: arm index in the cell; kObstacle: obstacle index
  int other_body = 0;     ///< index into that arm's bodies, or that obstacle's shapes
  int other_link = -1;    ///< link of that arm; −1: obstacle
  int part = 0;           ///< of a cloud of points, which has several pairs with one body; nearest first
  double distance = 0.0;  ///< [m]; negative: depth of penetration
  Eigen::Vector3d p_own_W = Eigen::Vector3d::Zero();    ///< nearest point on the own body [m]
  Eigen::Vector3d p_other_W = Eigen::Vector3d::Zero();  ///< nearest point on the other [m]
  /// Unit, from the own body towards the other: moving the own body along −n increases the distance, also in
  /// penetration. p_other_W = p_own_W + distance · n_W.
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
};

}  // namespace hecaton::planner
