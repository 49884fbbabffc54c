#include "planner/model/kinematics_kernels.hpp"

#include <cstddef>

#include "planner/simd/lanes.hpp"

namespace hecaton::planner::HECATON_ISA {
namespace {

/// The columns of a frame's rotation in W.
struct Frame {
  Lanes column[3];
};

// Rodrigues' formula for the columns of J = X_WP X_PJ and the axis a:
//   J R = c J + s J [a]× + (1 − c) (J a) aᵀ
Lanes turn(const ChainStep& step, Frame& frame) {
  auto& [x, y, z] = frame.column;
  const double* a = step.axis;
  const Lanes axis = x * a[0] + y * a[1] + z * a[2];
  const Lanes versed = axis * (1.0 - step.cosine);
  const Lanes turned_x = x * step.cosine + (y * a[2] - z * a[1]) * step.sine + versed * a[0];
  const Lanes turned_y = y * step.cosine + (z * a[0] - x * a[2]) * step.sine + versed * a[1];
  const Lanes turned_z = z * step.cosine + (x * a[1] - y * a[0]) * step.sine + versed * a[2];
  x = turned_x;
  y = turned_y;
  z = turned_z;
  return axis;
}

/// The same for the k-th unit vector as a, without products with zero and one, and with the same rounding.
template <int k>
Lanes turn_about(const ChainStep& step, Frame& frame) {
  Lanes& u = frame.column[k];
  Lanes& v = frame.column[(k + 1) % 3];
  Lanes& w = frame.column[(k + 2) % 3];
  const Lanes axis = u;
  const Lanes turned_v = v * step.cosine + w * step.sine;
  w = w * step.cosine - v * step.sine;
  v = turned_v;
  u = axis * step.cosine + axis * (1.0 - step.cosine);
  return axis;
}

/// Rotates the frame. Returns the joint's axis in W.
Lanes move(const ChainStep& step, Frame& frame) {
  switch (step.motion) {
    case JointMotion::kTurnsAboutX:
      return turn_about<0>(step, frame);
    case JointMotion::kTurnsAboutY:
      return turn_about<1>(step, frame);
    case JointMotion::kTurnsAboutZ:
      return turn_about<2>(step, frame);
    case JointMotion::kFixed:
      return Lanes{};
    case JointMotion::kMoves:
      break;
  }
  return turn(step, frame);
}

}  // namespace

void place_chain(ChainStep* steps, int count) {
  for (int i = 0; i < count; ++i) {
    ChainStep& step = steps[i];
    const Lanes px = load(step.X_WP);
    const Lanes py = load(step.X_WP + 4);
    const Lanes pz = load(step.X_WP + 8);
    const auto column = [&](std::ptrdiff_t k) {
      return px * step.X_PJ[4 * k] + py * step.X_PJ[4 * k + 1] + pz * step.X_PJ[4 * k + 2];
    };
    Frame frame{{column(0), column(1), column(2)}};
    const Lanes origin = column(3) + load(step.X_WP + 12);
    const Lanes axis = move(step, frame);
    for (std::ptrdiff_t k = 0; k < 3; ++k) store(step.X_WL + 4 * k, frame.column[k]);
    store(step.X_WL + 12, origin + axis * step.shift);
    store(step.axis_W, axis);
    store(step.origin_W, origin);
  }
}

// Per unit rate of axis j the ball's centre c moves with ω × c + v, and other points at most |ω| r faster. The bound
// is Σⱼ |q̇ⱼ| (|ω × c + v| + |ω| r).
void bound_speeds(const JointMotions& motions, const double* speed, CarriedBall* balls, int count) {
  const double* const* const w = motions.angular_W;
  const double* const* const v = motions.linear_W;
  const Lanes counting{0.0, 1.0, 2.0, 3.0};
  for (int i = 0; i < count; ++i) {
    CarriedBall& ball = balls[i];
    const double* X = ball.X_WL;
    const double* c = ball.centre_L;
    store(ball.centre_W, load(X) * c[0] + load(X + 4) * c[1] + load(X + 8) * c[2] + load(X + 12));
    const double* p = ball.centre_W;
    Lanes sum{};
    for (int j = 0; j < ball.axes; j += kLanes) {
      const Vector<Lanes> angular{load(w[0] + j), load(w[1] + j), load(w[2] + j)};
      const Vector<Lanes> centre{angular.y * p[2] - angular.z * p[1] + load(v[0] + j),
                                 angular.z * p[0] - angular.x * p[2] + load(v[1] + j),
                                 angular.x * p[1] - angular.y * p[0] + load(v[2] + j)};
      // ω is a unit vector or zero, so that |ω| = ω · ω.
      const Lanes fastest = load(speed + j) * (sqrt(dot(centre, centre)) + dot(angular, angular) * ball.radius);
      sum += select(counting + j < all<Lanes>(ball.axes), fastest, Lanes{});
    }
    ball.fastest = (sum[0] + sum[2]) + (sum[1] + sum[3]);
  }
}

}  // namespace hecaton::planner::HECATON_ISA
