#pragma once
/// The part of a distance pass that runs in lanes: placing bodies, culling pairs by bounding volumes, nearest points of
/// segments and boxes. Plain arrays in and out, because the kernel is compiled once for each instruction set.

#include <cstdint>

namespace hecaton::planner {

/// A vector and one more number, as lanes load them.
struct alignas(32) Quad {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 0.0;
};

/// How the pass finds a pair's nearest points.
enum class BodyKind : std::uint8_t {
  kThin,   ///< a point or segment and a ball swept along it: in lanes
  kBox,    ///< in lanes, against thin ones
  kOther,  ///< one pair at a time, if the enclosing capsule is near
};

/// One body as lanes see it. The segment belongs to a thin body itself, or to the capsule that encloses another body.
struct LaneBody {
  Quad ball_C;    ///< centre of the bounding ball in the carrier's frame C [m]; w: its radius [m]
  Quad middle_C;  ///< of the segment [m]; w: radius of the capsule [m]
  Quad axis_C;    ///< unit; w: half length of the segment [m]
  Quad box_C[3];  ///< a box' axes, unit; w: half extents [m]
  BodyKind kind = BodyKind::kThin;
  bool in_place = false;  ///< ball and box are centred on C, with axes along those of C
};

/// Where a body is in this pass. The w of points is undefined.
struct LanePlace {
  Quad centre_W;  ///< of a box [m]
  Quad p_W;       ///< one end of the segment [m]
  Quad q_W;       ///< the other [m]
  Quad box_W[3];  ///< a box' axes, unit
};

/// The influence distance max(at_rest, moving + per_speed · v) [m] for an own body whose points move at most at v: it
/// grows with the speed, because fast bodies may collide sooner.
struct Reach {
  double at_rest = 0.0;    ///< [m]
  double moving = 0.0;     ///< [m]
  double per_speed = 0.0;  ///< [s]
};

/// Relative margin on lengths in floats: some twenty times the rounding error.
inline constexpr float kOutwards = 1e-5F;

/// Eight own bodies in floats, for culling, relative to the origin of the pass. Padding in the last group is far away.
struct alignas(32) OwnGroup {
  static constexpr int kBodies = 8;
  float ball_x[kBodies], ball_y[kBodies], ball_z[kBodies];  ///< centres of bounding balls [m]
  float ball_radius[kBodies];                               ///< [m]
  float p_x[kBodies], p_y[kBodies], p_z[kBodies];           ///< one end of the segments [m]
  float d_x[kBodies], d_y[kBodies], d_z[kBodies];           ///< from there to the other [m]
  float per_length2[kBodies];                               ///< 1/|d|², 0 for a point [1/m²]
  float capsule_radius[kBodies];                            ///< [m]
  float speed[kBodies];                                     ///< [m/s]
  float near[kBodies];                                      ///< influence distance for the current range [m]
  float near_ball[kBodies];                                 ///< near + ball_radius [m]
  unsigned bodies = 0;                                      ///< bit i: there is a body i
  unsigned moving = 0;                                      ///< bit i: some joint moves body i
};

/// Other bodies that the pass tests.
struct LaneRange {
  int first = 0;
  int end = 0;
  const Reach* reach = nullptr;  ///< one for all, or, with reach_of_each, one per body
  bool reach_of_each = false;
};

enum class PairState : std::uint8_t {
  kFar,       ///< not nearer than its limit
  kMeasured,  ///< see n_W, p_own_W, p_other_W
  kOpen,      ///< may be nearer: the caller measures it
};

struct LanePair {
  std::int32_t own = 0;
  std::int32_t other = 0;
  double limit = 0.0;  ///< influence distance [m]
  bool cull = false;   ///< segments and boxes only bound the distance of this pair: it ends kFar or kOpen
  PairState state = PairState::kOpen;
  Quad n_W;        ///< unit, own → other; w: distance [m]
  Quad p_own_W;    ///< [m]
  Quad p_other_W;  ///< [m]
};

/// One pass. Own bodies are 0 … own_count − 1, other bodies follow.
struct LanePass {
  const LaneBody* bodies = nullptr;
  const double* const* carrier = nullptr;  ///< X_WC of each body, 4 × 4, column by column
  LanePlace* places = nullptr;
  int own_count = 0;
  OwnGroup* own_groups = nullptr;                  ///< scratch; capsule_radius, ball_radius and moving are given
  const double* own_speed = nullptr;               ///< of each own body [m/s]
  const std::uint8_t* pairs_with_fixed = nullptr;  ///< per body: pairs with own bodies that no joint moves count, too
  const float* radius = nullptr;                   ///< of each bounding ball, rounded outwards [m]
  float* ball = nullptr;                           ///< scratch, four per body: centre of its bounding ball
  const LaneRange* ranges = nullptr;               ///< the other bodies to test
  int range_count = 0;
  int* thin_pairs = nullptr;  ///< scratch, one per possible pair
  int* box_pairs = nullptr;   ///< scratch, one per possible pair
  LanePair* pairs = nullptr;  ///< capacity for every possible pair; begins with the self pairs
  int pair_count = 0;         ///< in: self pairs; out: all candidates
};

/// Fills places, pairs and pair_count. Every pair nearer than its limit is in `pairs` and not kFar. Other pairs follow
/// the self pairs in the order of `ranges`, each with own bodies in order.
using PassKernel = void (*)(LanePass&);

/// The kernel for this machine's instruction set.
[[nodiscard]] PassKernel fastest_pass();

/// Both give the same result to the last bit.
namespace baseline {
void run_pass(LanePass& pass);
}
namespace avx2 {
void run_pass(LanePass& pass);
}

}  // namespace hecaton::planner
