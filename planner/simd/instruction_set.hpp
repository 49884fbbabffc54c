#pragma once
/// Which of a function's compilations this machine runs.

namespace hecaton::planner {

/// The best instruction set that the processor has, of those that files with lanes are compiled for.
[[nodiscard]] inline bool has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

template <typename Function>
[[nodiscard]] Function fastest(Function baseline, Function avx2) {
  return has_avx2() ? avx2 : baseline;
}

}  // namespace hecaton::planner
