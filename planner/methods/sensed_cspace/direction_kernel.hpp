#pragma once
/// The directions in which a link touches an obstacle, for several joint positions at once, in SIMD lanes. Compiled
/// once for each instruction set.

#include "planner/methods/sensed_cspace/planar_geometry.hpp"

namespace hecaton::planner::cspace {

struct DirectionQuery {
  const double* joint_x;  ///< joint positions [m]
  const double* joint_y;
  const double* forward_x;  ///< unit vectors of angle 0, one for each position
  const double* forward_y;
  const ConvexPiece* obstacle;
  double length;  ///< of the link [m], > 0
  double width;   ///< w of the link [m], > 0
};

/// Computes the directions for `count` joint positions, a multiple of four. The link touches the obstacle in the
/// directions from `right` counter-clockwise to `left`, both in [−π, π] [rad], with an error below 10⁻⁹ rad. All
/// directions are −2π and 2π; none are 2π and −2π.
using DirectionKernel = void (*)(const DirectionQuery& query, int count, double* right, double* left);

/// Both give bit-identical results.
namespace baseline {
void touching_directions(const DirectionQuery& query, int count, double* right, double* left);
}
namespace avx2 {
void touching_directions(const DirectionQuery& query, int count, double* right, double* left);
}

}  // namespace hecaton::planner::cspace
