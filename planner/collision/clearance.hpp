#pragma once
/// Signed distance between one of the arm's own bodies and something else.

#include <cstdint>

#include <Eigen/Core>

namespace hecaton::planner {

enum class Counterpart : std::uint8_t {
  kSelf,      ///< another body of the same arm
  kArm,       ///< a body of another arm
  kObstacle,  ///< a body of an obstacle
};

struct Clearance {
  int own_body = 0;  ///< index into CellGeometry::own_bodies()
  int own_link = 0;  ///< link of the own model that carries it
  Counterpart counterpart = Counterpart::kObstacle;
  int other = 0;          ///< kSelf: the arm itself; kArm: arm index in the cell; kObstacle: obstacle index
  int other_body = 0;     ///< index into that arm's bodies, or that obstacle's shapes
  int other_link = -1;    ///< link of that arm; −1 for an obstacle
  double distance = 0.0;  ///< [m]; negative: depth of penetration
  Eigen::Vector3d p_own_W = Eigen::Vector3d::Zero();    ///< nearest point on the own body [m]
  Eigen::Vector3d p_other_W = Eigen::Vector3d::Zero();  ///< nearest point on the other [m]
  /// Unit, from the own body towards the other: moving the own body along −n increases the distance, also in
  /// penetration. p_other_W = p_own_W + distance · n_W.
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
};

}  // namespace hecaton::planner
