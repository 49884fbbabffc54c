#include "planner/simd/sine_cosine.hpp"

#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner {

void sine_cosine(const double* angle, int count, double* sine, double* cosine) {
  static const auto chosen = fastest(baseline::sine_cosine, avx2::sine_cosine);
  chosen(angle, count, sine, cosine);
}

}  // namespace hecaton::planner
