#pragma once
/// Selection of a function's compilation for the instruction set of this machine.

namespace hecaton::planner {

/// True if the processor supports AVX2.
[[nodiscard]] inline bool has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

/// The compilation for the best supported instruction set. Thread-safe.
template <typename Function>
[[nodiscard]] Function fastest(Function baseline, Function avx2) {
  return has_avx2() ? avx2 : baseline;
}

}  // namespace hecaton::planner
