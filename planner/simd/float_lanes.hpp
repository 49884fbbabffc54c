#pragma once
/// SIMD lanes of floats for the collision kernel: 4, 8 (AVX2 and FMA) or 16 (AVX-512), whatever the file is compiled
/// for.
///
/// A port needs the compiler's vector types and the six functions below; the generic versions serve any processor with
/// vectors of 16 bytes, such as NEON. Products and sums may be fused, so results differ between instruction sets in the
/// last bits. Never include this file where lanes.hpp is included: those results are bit-identical everywhere.
/// HECATON_ISA is the namespace of one compilation, so that the linker never mixes them.

#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// Lanes are passed only between inline functions of one file, so the calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

#ifndef HECATON_ISA
#define HECATON_ISA lanes4
#endif

namespace hecaton::planner::HECATON_ISA {

#if defined(__AVX512F__)
inline constexpr int kFloats = 16;
#elif defined(__AVX2__)
inline constexpr int kFloats = 8;
#else
inline constexpr int kFloats = 4;
#endif
using Floats = float __attribute__((vector_size(kFloats * sizeof(float))));
using Integers = int __attribute__((vector_size(kFloats * sizeof(int))));

/// One bit for each lane.
using Bits = unsigned;
inline constexpr Bits kAllLanes = (1U << kFloats) - 1U;

/// The same value in every lane.
inline Floats all(float value) {
  return Floats{} + value;
}
inline Floats load(const float* from) {
  Floats lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}
inline void store(float* to, Floats lanes) {
  std::memcpy(to, &lanes, sizeof(lanes));
}

/// The lanes in which a < b does not fail; a comparison with NaN does not fail.
inline Bits below(Floats a, Floats b) {
#if defined(__AVX512F__)
  return _mm512_cmp_ps_mask(a, b, _CMP_NGE_UQ);
#elif defined(__AVX2__)
  return static_cast<Bits>(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_NGE_UQ)));
#elif defined(__SSE2__)
  return static_cast<Bits>(_mm_movemask_ps(_mm_cmpnge_ps(a, b)));
#else
  Bits bits = 0;
  for (int i = 0; i < kFloats; ++i) bits |= a[i] >= b[i] ? 0U : 1U << i;
  return bits;
#endif
}
inline Floats min(Floats a, Floats b) {
#if defined(__AVX512F__)
  return _mm512_min_ps(a, b);
#elif defined(__AVX2__)
  return _mm256_min_ps(a, b);
#elif defined(__SSE2__)
  return _mm_min_ps(a, b);
#else
  return a < b ? a : b;
#endif
}
inline Floats max(Floats a, Floats b) {
#if defined(__AVX512F__)
  return _mm512_max_ps(a, b);
#elif defined(__AVX2__)
  return _mm256_max_ps(a, b);
#elif defined(__SSE2__)
  return _mm_max_ps(a, b);
#else
  return a > b ? a : b;
#endif
}
inline Floats sqrt(Floats x) {
#if defined(__AVX512F__)
  return _mm512_sqrt_ps(x);
#elif defined(__AVX2__)
  return _mm256_sqrt_ps(x);
#elif defined(__SSE2__)
  return _mm_sqrt_ps(x);
#else
  for (int i = 0; i < kFloats; ++i) x[i] = std::sqrt(x[i]);
  return x;
#endif
}
/// Each lane gets the value of the next one; the last lane keeps its own.
inline Floats next_lane(Floats x) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(x, x, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 15);
#elif defined(__AVX2__)
  return __builtin_shufflevector(x, x, 1, 2, 3, 4, 5, 6, 7, 7);
#else
  return __builtin_shufflevector(x, x, 1, 2, 3, 3);
#endif
}

inline Floats abs(Floats x) {
  return max(x, -x);
}
inline Floats clamp(Floats x, Floats low, Floats high) {
  return min(max(x, low), high);
}

/// 0, 1, 2, …
inline Floats lane_numbers() {
  Floats numbers;
  for (int i = 0; i < kFloats; ++i) numbers[i] = static_cast<float>(i);
  return numbers;
}

/// The smallest lanes of x, y and z, and the negative largest ones: in out[0 … 2] and out[4 … 6].
inline void extremes(Floats x, Floats y, Floats z, float* out) {
#if defined(__AVX2__)
  // The lower half of a register holds candidates for the smallest lane, the upper half negative ones for the largest.
  const auto folded = [](Floats v) {
#if defined(__AVX512F__)
    const __m256 one = __builtin_shufflevector(v, v, 0, 1, 2, 3, 4, 5, 6, 7);
    const __m256 two = __builtin_shufflevector(v, v, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m256 low = _mm256_min_ps(one, two);
    const __m256 high = -_mm256_max_ps(one, two);
#else
    const __m256 low = v;
    const __m256 high = -v;
#endif
    return _mm256_min_ps(_mm256_permute2f128_ps(low, high, 0x20), _mm256_permute2f128_ps(low, high, 0x31));
  };
  const __m256 fx = folded(x);
  const __m256 fy = folded(y);
  const __m256 fz = folded(z);
  const __m256 xy = _mm256_min_ps(_mm256_unpacklo_ps(fx, fy), _mm256_unpackhi_ps(fx, fy));
  const __m256 zz = _mm256_min_ps(_mm256_unpacklo_ps(fz, fz), _mm256_unpackhi_ps(fz, fz));
  _mm256_storeu_ps(out, _mm256_min_ps(_mm256_shuffle_ps(xy, zz, 0x44), _mm256_shuffle_ps(xy, zz, 0xEE)));
#else
  const Floats* coordinates[] = {&x, &y, &z};
  for (int k = 0; k < 3; ++k) {
    const Floats& v = *coordinates[k];
    out[k] = v[0];
    out[k + 4] = -v[0];
    for (int i = 1; i < kFloats; ++i) {
      out[k] = v[i] < out[k] ? v[i] : out[k];
      out[k + 4] = -v[i] < out[k + 4] ? -v[i] : out[k + 4];
    }
  }
#endif
}

/// Cody and Waite's reduction by π/2 in two parts, then minimax polynomials on ±π/4: within 2.5·10⁻⁷ for |x| ≤ 40.
inline void sine_cosine(Floats x, Floats& sine, Floats& cosine) {
  const Floats quarters = x * 0.636619772F + 12582912.0F;  // 1.5 · 2²³: adding it rounds to a whole number
  const Floats n = quarters - 12582912.0F;
  const Floats r = (x - n * 1.5707855225F) - n * 1.0804334124e-5F;
  const Floats z = r * r;
  const Floats s = r + r * (z * (-1.6666654611e-1F + z * (8.3321608736e-3F + z * -1.9515295891e-4F)));
  const Floats c =
      1.0F - 0.5F * z + z * z * (4.166664568298827e-2F + z * (-1.388731625493765e-3F + z * 2.443315711809948e-5F));
  Integers quadrant;
  std::memcpy(&quadrant, &quarters, sizeof(quadrant));
  const Integers odd = (quadrant & 1) != 0;
  const Floats a = odd ? c : s;
  const Floats b = odd ? s : c;
  // The sign bits, moved in place.
  Integers sine_bits, cosine_bits;
  std::memcpy(&sine_bits, &a, sizeof(a));
  std::memcpy(&cosine_bits, &b, sizeof(b));
  sine_bits ^= (quadrant & 2) << 30;
  cosine_bits ^= ((quadrant + 1) & 2) << 30;
  std::memcpy(&sine, &sine_bits, sizeof(sine));
  std::memcpy(&cosine, &cosine_bits, sizeof(cosine));
}

}  // namespace hecaton::planner::HECATON_ISA
