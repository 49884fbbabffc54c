#include "planner/simd/lanes.hpp"
#include "planner/simd/sine_cosine.hpp"

namespace hecaton::planner::HECATON_ISA {
namespace {

/// Adding and subtracting this constant rounds to an integer, which the last bits of the sum hold.
constexpr double kRounder = 0x1.8p52;
constexpr double kQuartersPerRadian = 0x1.45f306dc9c883p-1;  // 2/π
/// π/2 in three parts of 33 bits: products with integers of up to 20 bits are exact.
constexpr double kQuarter1 = 0x1.921fb544p+0;
constexpr double kQuarter2 = 0x1.0b4611a6p-34;
constexpr double kQuarter3 = 0x1.3198a2e037073p-69;

/// Taylor series to the terms in r¹⁵ and r¹⁶: on |r| ≤ π/4 the rest is below 5·10⁻¹⁷.
Lanes sine_near_zero(Lanes r) {
  constexpr double k15 = -1.0 / 1307674368000.0;
  constexpr double k13 = 1.0 / 6227020800.0;
  constexpr double k11 = -1.0 / 39916800.0;
  constexpr double k9 = 1.0 / 362880.0;
  constexpr double k7 = -1.0 / 5040.0;
  constexpr double k5 = 1.0 / 120.0;
  constexpr double k3 = -1.0 / 6.0;
  const Lanes z = r * r;
  return r + r * (z * ((((((k15 * z + k13) * z + k11) * z + k9) * z + k7) * z + k5) * z + k3));
}
Lanes cosine_near_zero(Lanes r) {
  constexpr double k16 = 1.0 / 20922789888000.0;
  constexpr double k14 = -1.0 / 87178291200.0;
  constexpr double k12 = 1.0 / 479001600.0;
  constexpr double k10 = -1.0 / 3628800.0;
  constexpr double k8 = 1.0 / 40320.0;
  constexpr double k6 = -1.0 / 720.0;
  constexpr double k4 = 1.0 / 24.0;
  const Lanes z = r * r;
  return 1.0 - (0.5 * z - z * (z * ((((((k16 * z + k14) * z + k12) * z + k10) * z + k8) * z + k6) * z + k4)));
}

void four(const double* angle, double* sine, double* cosine) {
  const Lanes x = load(angle);
  const Lanes rounded = x * kQuartersPerRadian + kRounder;
  const Lanes quarters = rounded - kRounder;
  const Lanes r = x - quarters * kQuarter1 - quarters * kQuarter2 - quarters * kQuarter3;
  const Lanes s = sine_near_zero(r);
  const Lanes c = cosine_near_zero(r);
  LaneMask quadrant;
  std::memcpy(&quadrant, &rounded, sizeof(quadrant));
  const LaneMask odd = (quadrant & 1) != 0;
  const LaneMask sine_negative = (quadrant & 2) != 0;
  const LaneMask cosine_negative = ((quadrant + 1) & 2) != 0;
  const Lanes sine_size = select(odd, c, s);
  const Lanes cosine_size = select(odd, s, c);
  store(sine, select(sine_negative, -sine_size, sine_size));
  store(cosine, select(cosine_negative, -cosine_size, cosine_size));
}

}  // namespace

void sine_cosine(const double* angle, int count, double* sine, double* cosine) {
  for (int i = 0; i < count; i += kLanes) four(angle + i, sine + i, cosine + i);
}

}  // namespace hecaton::planner::HECATON_ISA
