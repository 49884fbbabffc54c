#include "planner/model/chain_kernel.hpp"

#include <cstddef>

#include "planner/simd/lanes.hpp"

namespace hecaton::planner::HECATON_ISA {

// With J = X_WP X_PJ and a the axis, Rodrigues' formula turns J's columns:
//   J R = c J + s J [a]× + (1 − c) (J a) aᵀ
void place_chain(ChainStep* steps, int count) {
  for (int i = 0; i < count; ++i) {
    ChainStep& step = steps[i];
    const Lanes px = load(step.X_WP);
    const Lanes py = load(step.X_WP + 4);
    const Lanes pz = load(step.X_WP + 8);
    const auto column = [&](std::ptrdiff_t k) {
      return px * step.X_PJ[4 * k] + py * step.X_PJ[4 * k + 1] + pz * step.X_PJ[4 * k + 2];
    };
    const Lanes x = column(0);
    const Lanes y = column(1);
    const Lanes z = column(2);
    const Lanes origin = column(3) + load(step.X_WP + 12);

    const double* a = step.axis;
    const Lanes axis = x * a[0] + y * a[1] + z * a[2];
    const Lanes versed = axis * (1.0 - step.cosine);
    const Lanes turned_x = x * step.cosine + (y * a[2] - z * a[1]) * step.sine + versed * a[0];
    const Lanes turned_y = y * step.cosine + (z * a[0] - x * a[2]) * step.sine + versed * a[1];
    const Lanes turned_z = z * step.cosine + (x * a[1] - y * a[0]) * step.sine + versed * a[2];

    store(step.X_WL, turned_x);
    store(step.X_WL + 4, turned_y);
    store(step.X_WL + 8, turned_z);
    store(step.X_WL + 12, origin + axis * step.shift);
    store(step.axis_W, axis);
    store(step.origin_W, origin);
  }
}

}  // namespace hecaton::planner::HECATON_ISA
