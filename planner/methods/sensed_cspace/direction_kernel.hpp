#pragma once
/// In which directions a turning link touches an obstacle, for several places of its joint at once, in lanes. Compiled
/// once for each instruction set.

#include "planner/methods/sensed_cspace/planar_geometry.hpp"

namespace hecaton::planner::cspace {

struct DirectionQuery {
  const double* joint_x;  ///< of each place of the joint [m]
  const double* joint_y;
  const double* forward_x;  ///< unit vector from which the angles count, for each place
  const double* forward_y;
  const ConvexPiece* obstacle;
  double length;  ///< of the link, from the joint on [m], > 0
  double width;   ///< w of the link [m], > 0
};

/// For `count` places of the joint, a whole number of fours: the link touches the obstacle in the directions from
/// `right` on counter-clockwise to `left`, both in [−π, π] [rad], within 10⁻⁹ rad. Whatever the direction: −2π and 2π;
/// in none: 2π and −2π.
using DirectionKernel = void (*)(const DirectionQuery& query, int count, double* right, double* left);

/// Both give the same result to the last bit.
namespace baseline {
void touching_directions(const DirectionQuery& query, int count, double* right, double* left);
}
namespace avx2 {
void touching_directions(const DirectionQuery& query, int count, double* right, double* left);
}

}  // namespace hecaton::planner::cspace
