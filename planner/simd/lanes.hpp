#pragma once
/// SIMD lanes of four doubles or eight floats, and functions that let one template serve scalars and lanes.
///
/// Files with lanes are compiled once for each instruction set. HECATON_ISA is their namespace, so that the linker
/// never mixes them; instruction_set.hpp selects one at run time. All operations are +, −, ×, ÷, √, min, max and
/// comparisons, each rounded once (no FMA). Results are bit-identical on every machine, for lanes and scalars.

#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// Lanes are passed only between inline functions of one file, so the calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

#ifndef HECATON_ISA
#define HECATON_ISA baseline
#endif

namespace hecaton::planner::HECATON_ISA {

inline constexpr int kLanes = 4;
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));
using LaneMask = decltype(Lanes{} < Lanes{});

inline Lanes load(const double* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}
inline void store(double* to, Lanes lanes) {
  std::memcpy(to, &lanes, sizeof(lanes));
}

/// The same value in every lane, or the scalar itself.
template <typename T>
inline T all(double value) {
  if constexpr (sizeof(T) == sizeof(double)) {
    return value;
  } else {
    return T{value, value, value, value};
  }
}

inline double select(bool mask, double yes, double no) {
  return mask ? yes : no;
}
inline Lanes select(LaneMask mask, Lanes yes, Lanes no) {
  return mask ? yes : no;
}
inline bool both(bool a, bool b) {
  return a && b;
}
inline LaneMask both(LaneMask a, LaneMask b) {
  return a & b;
}

inline double min(double a, double b) {
  return a < b ? a : b;
}
inline double max(double a, double b) {
  return a > b ? a : b;
}
inline double sqrt(double x) {
  return std::sqrt(x);
}

#if defined(__AVX2__)
inline Lanes min(Lanes a, Lanes b) {
  return _mm256_min_pd(a, b);
}
inline Lanes max(Lanes a, Lanes b) {
  return _mm256_max_pd(a, b);
}
inline Lanes sqrt(Lanes x) {
  return _mm256_sqrt_pd(x);
}
/// Bit i: lane i.
inline unsigned bits(LaneMask mask) {
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
}
#else
inline Lanes min(Lanes a, Lanes b) {
  return a < b ? a : b;
}
inline Lanes max(Lanes a, Lanes b) {
  return a > b ? a : b;
}
inline Lanes sqrt(Lanes x) {
  for (int i = 0; i < kLanes; ++i) x[i] = std::sqrt(x[i]);
  return x;
}
inline unsigned bits(LaneMask mask) {
  unsigned result = 0;
  for (int i = 0; i < kLanes; ++i) result |= mask[i] != 0 ? 1U << i : 0U;
  return result;
}
#endif

/// Eight floats, for bounds that are rounded outwards. They only decide whether an exact computation follows.
inline constexpr int kFloatLanes = 8;
using FloatLanes = float __attribute__((vector_size(kFloatLanes * sizeof(float))));
using FloatMask = decltype(FloatLanes{} < FloatLanes{});
/// Four doubles, rounded.
using FourFloats = float __attribute__((vector_size(kLanes * sizeof(float))));
inline FourFloats min(FourFloats a, FourFloats b) {
  return a < b ? a : b;
}

inline FourFloats rounded(Lanes lanes) {
  return __builtin_convertvector(lanes, FourFloats);
}
inline FloatLanes load(const float* from) {
  FloatLanes lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}
inline void store(float* to, FloatLanes lanes) {
  std::memcpy(to, &lanes, sizeof(lanes));
}
inline void store(float* to, FourFloats lanes) {
  std::memcpy(to, &lanes, sizeof(lanes));
}
inline FloatLanes all_floats(float value) {
  return FloatLanes{value, value, value, value, value, value, value, value};
}
#if defined(__AVX2__)
inline FloatLanes min(FloatLanes a, FloatLanes b) {
  return _mm256_min_ps(a, b);
}
inline FloatLanes max(FloatLanes a, FloatLanes b) {
  return _mm256_max_ps(a, b);
}
inline FloatLanes sqrt(FloatLanes x) {
  return _mm256_sqrt_ps(x);
}
inline unsigned bits(FloatMask mask) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
}
#else
inline FloatLanes min(FloatLanes a, FloatLanes b) {
  return a < b ? a : b;
}
inline FloatLanes max(FloatLanes a, FloatLanes b) {
  return a > b ? a : b;
}
inline FloatLanes sqrt(FloatLanes x) {
  for (int i = 0; i < kFloatLanes; ++i) x[i] = std::sqrt(x[i]);
  return x;
}
inline unsigned bits(FloatMask mask) {
  unsigned result = 0;
  for (int i = 0; i < kFloatLanes; ++i) result |= mask[i] != 0 ? 1U << i : 0U;
  return result;
}
#endif

template <typename T>
inline T clamp(T x, T low, T high) {
  return min(max(x, low), high);
}

/// A vector in space: one, or four with a lane each.
template <typename T>
struct Vector {
  T x, y, z;

  friend Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vector operator*(const T& s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend Vector operator/(const Vector& a, const T& s) { return {a.x / s, a.y / s, a.z / s}; }
};

template <typename T>
inline T dot(const Vector<T>& a, const Vector<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename T>
inline Vector<T> min(const Vector<T>& a, const Vector<T>& b) {
  return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
}
template <typename T>
inline Vector<T> max(const Vector<T>& a, const Vector<T>& b) {
  return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
}
template <typename T, typename Mask>
inline Vector<T> select(Mask mask, const Vector<T>& yes, const Vector<T>& no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}

/// Four vectors in memory (x, y, z, unused) as one vector of lanes.
inline Vector<Lanes> transposed(Lanes a, Lanes b, Lanes c, Lanes d) {
  const Lanes ab_xz = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const Lanes ab_y = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes cd_xz = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const Lanes cd_y = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return {__builtin_shufflevector(ab_xz, cd_xz, 0, 1, 4, 5), __builtin_shufflevector(ab_y, cd_y, 0, 1, 4, 5),
          __builtin_shufflevector(ab_xz, cd_xz, 2, 3, 6, 7)};
}

}  // namespace hecaton::planner::HECATON_ISA
