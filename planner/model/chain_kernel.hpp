#pragma once
/// Poses along a chain of links, a column of each at a time in lanes. Compiled once for each instruction set.

#include "planner/model/joint_motion.hpp"

namespace hecaton::planner {

/// One link: X_WL = X_WP · X_PJ · (turn about, then shift along, the axis). A joint that does not turn has sine 0 and
/// cosine 1, one that does not shift has shift 0. Poses are 4 × 4, column by column.
struct ChainStep {
  JointMotion motion;
  const double* X_WP;  ///< of the parent; may be the X_WL of an earlier step
  const double* X_PJ;  ///< joint frame in the parent's
  const double* axis;  ///< unit, in the joint's frame
  double sine;         ///< of the angle
  double cosine;       ///< of the angle
  double shift;        ///< [m]
  double* X_WL;        ///< out
  double axis_W[4];    ///< out; the fourth is rubbish
  double origin_W[4];  ///< out: of the joint's frame, before the shift [m]
};

using ChainKernel = void (*)(ChainStep* steps, int count);

/// Both give the same result to the last bit.
namespace baseline {
void place_chain(ChainStep* steps, int count);
}
namespace avx2 {
void place_chain(ChainStep* steps, int count);
}

}  // namespace hecaton::planner
