#include "planner/model/chain_kernel.hpp"

#include <cstddef>

#include "planner/simd/lanes.hpp"

namespace hecaton::planner::HECATON_ISA {

namespace {

/// The columns of a frame's rotation in W.
struct Frame {
  Lanes column[3];
};

// With J = X_WP X_PJ and a the axis, Rodrigues' formula turns J's columns:
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

/// The same where a is the k-th unit vector: without what it multiplies by zero or one, but rounded alike.
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

/// Turns the frame; its joint's axis in W.
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

}  // namespace hecaton::planner::HECATON_ISA
