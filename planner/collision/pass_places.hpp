#pragma once
/// Where the bodies of a pass are, each a lane for x, y and z.

#include "planner/collision/pass_kernels.hpp"
#include "planner/simd/lanes.hpp"

namespace hecaton::planner::HECATON_ISA {

inline Lanes load(const Quad& quad) {
  return HECATON_ISA::load(&quad.x);
}
inline void store(Quad& quad, Lanes lanes) {
  HECATON_ISA::store(&quad.x, lanes);
}

/// The columns of a pose, a lane each for x, y, z.
struct Columns {
  Lanes x, y, z, t;
  explicit Columns(const double* X)
      : x(HECATON_ISA::load(X)),
        y(HECATON_ISA::load(X + 4)),
        z(HECATON_ISA::load(X + 8)),
        t(HECATON_ISA::load(X + 12)) {}
  [[nodiscard]] Lanes turned(const Quad& v) const { return x * v.x + y * v.y + z * v.z; }
  [[nodiscard]] Lanes placed(const Quad& p) const { return turned(p) + t; }
};

/// Centre of the bounding ball in W.
inline Lanes place_ball(const LanePass& pass, int body) {
  const LaneBody& from = pass.bodies[body];
  const Columns X_WC(pass.carrier[body]);
  return from.in_place ? X_WC.t : X_WC.placed(from.ball_C);
}

/// Fills in where the segment or box is.
inline void place_shape(const LanePass& pass, int body) {
  const LaneBody& from = pass.bodies[body];
  LanePlace& to = pass.places[body];
  const Columns X_WC(pass.carrier[body]);
  if (from.kind == BodyKind::kBox && from.in_place) {
    store(to.box_W[0], X_WC.x);
    store(to.box_W[1], X_WC.y);
    store(to.box_W[2], X_WC.z);
    store(to.centre_W, X_WC.t);
    return;
  }
  if (from.kind == BodyKind::kBox) {
    store(to.centre_W, X_WC.placed(from.ball_C));
    for (int i = 0; i < 3; ++i) store(to.box_W[i], X_WC.turned(from.box_C[i]));
    return;
  }
  const Lanes middle = X_WC.placed(from.middle_C);
  const Lanes half = X_WC.turned(from.axis_C) * from.axis_C.w;
  store(to.p_W, middle - half);
  store(to.q_W, middle + half);
}

}  // namespace hecaton::planner::HECATON_ISA
