#pragma once
/// The kernels of kinematics: poses along a chain of links, and bounds on the speed of what an arm carries. Each is
/// compiled once for every instruction set, with the same result to the last bit; plain arrays in and out.

#include <cstdint>

namespace hecaton::planner {

/// How a joint moves its link. All but kMoves are special cases of kMoves that need less arithmetic and give the same
/// result to the last bit.
enum class JointMotion : std::uint8_t {
  kTurnsAboutX,
  kTurnsAboutY,
  kTurnsAboutZ,
  kFixed,
  kMoves,  ///< rotates about any axis, then translates along it
};

/// One link: X_WL = X_WP · X_PJ · (rotation about, then translation along, the axis). Without rotation sine is 0 and
/// cosine 1; without translation shift is 0. Poses are 4 × 4, column by column.
struct ChainStep {
  JointMotion motion;
  const double* X_WP;  ///< of the parent; may be the X_WL of an earlier step
  const double* X_PJ;  ///< joint frame in the parent's
  const double* axis;  ///< unit, in the joint's frame
  double sine;         ///< of the angle
  double cosine;       ///< of the angle
  double shift;        ///< [m]
  double* X_WL;        ///< out
  double axis_W[4];    ///< out; the fourth is undefined
  double origin_W[4];  ///< out: of the joint's frame, before the shift [m]
};

/// Computes `count` steps in order.
using ChainKernel = void (*)(ChainStep* steps, int count);

namespace baseline {
void place_chain(ChainStep* steps, int count);
}
namespace avx2 {
void place_chain(ChainStep* steps, int count);
}

/// A ball that is fixed to a link.
struct CarriedBall {
  const double* X_WL = nullptr;  ///< of the link, 4 × 4, column by column
  double centre_L[3] = {};       ///< [m]
  double radius = 0.0;           ///< [m]
  int axes = 0;                  ///< number of axes that move it: 0 … axes − 1
  double centre_W[4] = {};       ///< out [m]; the fourth is undefined
  double fastest = 0.0;          ///< out: no point of the ball moves faster [m/s]
};

/// Kinematics::angular_W and linear_W: the velocity of a point per rate of an axis. Padded to groups of four axes.
struct JointMotions {
  const double* angular_W[3];
  const double* linear_W[3];
};

/// Fills centre_W and fastest of `count` balls for axes whose rates are at most `speed` in magnitude [rad/s | m/s],
/// padded to groups of four.
using SpeedKernel = void (*)(const JointMotions& motions, const double* speed, CarriedBall* balls, int count);

namespace baseline {
void bound_speeds(const JointMotions& motions, const double* speed, CarriedBall* balls, int count);
}
namespace avx2 {
void bound_speeds(const JointMotions& motions, const double* speed, CarriedBall* balls, int count);
}

}  // namespace hecaton::planner
