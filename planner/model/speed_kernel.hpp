#pragma once
/// Bounds on the speed of everything an arm carries, several joints at a time in lanes. Compiled once for each
/// instruction set.

namespace hecaton::planner {

/// A ball that is fixed to a link.
struct CarriedBall {
  const double* X_WL = nullptr;  ///< of the link, 4 × 4, column by column
  double centre_L[3] = {};       ///< [m]
  double radius = 0.0;           ///< [m]
  int joints = 0;                ///< that move it, from the base on
  double centre_W[4] = {};       ///< out [m]; the fourth is rubbish
  double fastest = 0.0;          ///< out: no point of the ball moves faster [m/s]
};

/// What the rates of an arm's joints do to the point at p_W: Kinematics::angular_W and linear_W, whole groups of four.
struct JointMotions {
  const double* angular_W[3];
  const double* linear_W[3];
};

/// Fills centre_W and fastest of `count` balls for joints that turn or shift no faster than `speed` either way, whole
/// groups of four.
using SpeedKernel = void (*)(const JointMotions& motions, const double* speed, CarriedBall* balls, int count);

/// Both give the same result to the last bit.
namespace baseline {
void bound_speeds(const JointMotions& motions, const double* speed, CarriedBall* balls, int count);
}
namespace avx2 {
void bound_speeds(const JointMotions& motions, const double* speed, CarriedBall* balls, int count);
}

}  // namespace hecaton::planner
