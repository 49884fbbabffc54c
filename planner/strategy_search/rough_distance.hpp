#pragma once
/// Distances of two arms in single precision, eight capsules at a time. Where rounding could matter, double precision
/// decides, so that the simulation is the same to the last bit.

#include <bit>

#include "planner/strategy_search/flat_kernels.hpp"

namespace hecaton::planner::HECATON_ISA {

/// Places of an arm's capsules in W: x, y, z of the segments' midpoints, then of the vectors from there to an end;
/// bodies in lanes [m]. rough_numbers() floats; padding lanes are far away.
struct RoughPlace {
  alignas(32) float numbers[kMaxRoughNumbers];
};

/// The shapes of an arm's capsules, bodies in lanes.
struct RoughArm {
  alignas(32) float length2[kFlatBodies] = {};   ///< of half a segment, squared [m²]
  alignas(32) float inverse2[kFlatBodies] = {};  ///< 1/length2, 0 for a point [1/m²]
  alignas(32) float radius[kFlatBodies] = {};    ///< [m]
  alignas(32) float reach[kFlatBodies] = {};     ///< FlatBody::reach [m]
  /// A large distance for padding lanes (`padding`), and for these and fixed bodies (`excluded`); 0 otherwise [m].
  alignas(32) float padding[kFlatBodies] = {};
  alignas(32) float excluded[kFlatBodies] = {};
  int fixed = 0;
  int bodies = 0;
  std::ptrdiff_t stride = 0;  ///< floats from one coordinate to the next in a RoughPlace

  void begin(const FlatArm& arm) {
    fixed = arm.fixed;
    bodies = arm.bodies;
    stride = rough_numbers(arm) / 6;
    constexpr float kBeyond = 1e7F;
    for (int i = arm.bodies; i < kFlatBodies; ++i) padding[i] = excluded[i] = kBeyond;
    for (int i = 0; i < arm.fixed; ++i) excluded[i] = kBeyond;
    for (int i = 0; i < arm.bodies; ++i) {
      const FlatBody& body = arm.body[i];
      length2[i] = static_cast<float>(body.inverse2 > 0.0 ? 0.25 / body.inverse2 : 0.0);
      inverse2[i] = static_cast<float>(4.0 * body.inverse2);
      radius[i] = static_cast<float>(body.radius);
      reach[i] = static_cast<float>(body.reach);
    }
  }
};

/// Transposes four bodies in four configurations.
inline void put_transposed(const Lanes* bodies, float* const* configurations) {
  using Four = FourFloats;
  const Four a = rounded(bodies[0]);
  const Four b = rounded(bodies[1]);
  const Four c = rounded(bodies[2]);
  const Four d = rounded(bodies[3]);
  const Four ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Four ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Four cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Four cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  store(configurations[0], __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5));
  store(configurations[1], __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7));
  store(configurations[2], __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5));
  store(configurations[3], __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7));
}

/// Rounds four configurations to separate RoughPlaces.
inline void round_places(const FlatArm& arm, const FourPlaces& places, float* const* rough) {
  constexpr double kFarAway = 1e6;
  const std::ptrdiff_t stride = rough_numbers(arm) / 6;
  const auto put = [&](int from, int axis, Lanes Point::*coordinate) {
    Lanes p[kLanes];
    Lanes d[kLanes];
    for (int k = 0; k < kLanes; ++k) {
      const bool used = from + k < arm.bodies;
      p[k] = used ? places.middle[from + k].*coordinate : four(kFarAway);
      d[k] = used ? four(0.5) * places.d[from + k].*coordinate : four(0.0);
    }
    float* to[kLanes];
    for (int k = 0; k < kLanes; ++k) to[k] = rough[k] + axis * stride + from;
    put_transposed(p, to);
    for (float*& place : to) place += 3 * stride;
    put_transposed(d, to);
  };
  for (int from = 0; from < stride; from += kLanes) {
    put(from, 0, &Point::x);
    put(from, 1, &Point::y);
    put(from, 2, &Point::z);
  }
}

/// One body in all lanes.
struct RoughBody {
  FloatLanes mx, my, mz;
  FloatLanes dx, dy, dz;

  RoughBody(const float* at, std::ptrdiff_t stride, int i)
      : mx(all_floats(at[i])),
        my(all_floats(at[stride + i])),
        mz(all_floats(at[2 * stride + i])),
        dx(all_floats(at[3 * stride + i])),
        dy(all_floats(at[4 * stride + i])),
        dz(all_floats(at[5 * stride + i])) {}
};

/// A determinant below this share of |d|²|d'|² is mostly rounding; |gap|² is then wrong by at most this share of |d|².
inline constexpr float kParallel = 1e-6F;

struct RoughGaps {
  FloatLanes distance;  ///< [m]
  FloatLanes x, y, z;   ///< from the other's segments to this one's [m]
};

/// Distances of body i of an arm to eight bodies of another. As segment_distance2(), but from the midpoints, with
/// parameters in [−1, 1].
inline RoughGaps rough_gaps(const RoughArm& arm, const RoughBody& body, int i, const RoughArm& other,
                            const float* there, int from) {
  const FloatLanes one = all_floats(1.0F);
  const FloatLanes ox = load(there + 3 * other.stride + from);
  const FloatLanes oy = load(there + 4 * other.stride + from);
  const FloatLanes oz = load(there + 5 * other.stride + from);
  const FloatLanes rx = body.mx - load(there + from);
  const FloatLanes ry = body.my - load(there + other.stride + from);
  const FloatLanes rz = body.mz - load(there + 2 * other.stride + from);
  const FloatLanes oo = load(other.length2 + from);
  const FloatLanes b = body.dx * ox + body.dy * oy + body.dz * oz;
  const FloatLanes c = body.dx * rx + body.dy * ry + body.dz * rz;
  const FloatLanes f = ox * rx + oy * ry + oz * rz;
  const FloatLanes squares = all_floats(arm.length2[i]) * oo;
  const FloatLanes determinant = squares - b * b;
  const FloatLanes crossing = min(max((b * f - c * oo) / determinant, -one), one);
  const FloatLanes first = determinant > all_floats(kParallel) * squares ? crossing : all_floats(0.0F);
  const FloatLanes t = min(max((b * first + f) * load(other.inverse2 + from), -one), one);
  const FloatLanes s = min(max((b * t - c) * all_floats(arm.inverse2[i]), -one), one);
  const FloatLanes gx = rx + s * body.dx - t * ox;
  const FloatLanes gy = ry + s * body.dy - t * oy;
  const FloatLanes gz = rz + s * body.dz - t * oz;
  const FloatLanes length = sqrt(gx * gx + gy * gy + gz * gz);
  return {length - all_floats(arm.radius[i]) - load(other.radius + from), gx, gy, gz};
}

/// True if the bounding sphere of any of eight bodies is within `limit` of that of body i.
inline bool rough_may_be_near(const RoughArm& arm, const RoughBody& body, int i, const RoughArm& other,
                              const float* there, int from, float limit) {
  const FloatLanes rx = body.mx - load(there + from);
  const FloatLanes ry = body.my - load(there + other.stride + from);
  const FloatLanes rz = body.mz - load(there + 2 * other.stride + from);
  const FloatLanes near = load(other.reach + from) + all_floats(arm.reach[i] + limit);
  return bits(rx * rx + ry * ry + rz * rz < near * near) != 0;
}

inline float least_of(const FloatLanes& x) {
  const FourFloats halves = min(__builtin_shufflevector(x, x, 0, 1, 2, 3), __builtin_shufflevector(x, x, 4, 5, 6, 7));
  const FourFloats pairs = min(halves, __builtin_shufflevector(halves, halves, 2, 3, 0, 1));
  return pairs[0] < pairs[1] ? pairs[0] : pairs[1];
}

/// Normal in W of a plane between two arms.
struct RoughNormal {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
};

/// Gap along n between an arm and another arm [m]: a lower bound of their distance. Fixed bodies of the first arm do
/// not count. n points towards the first arm and has length 1. If its length is 0, the result is ≤ 0.
inline float rough_gap_along(const RoughArm& arm, const float* at, const RoughArm& other, const float* there,
                             const RoughNormal& n) {
  const FloatLanes x = all_floats(n.x);
  const FloatLanes y = all_floats(n.y);
  const FloatLanes z = all_floats(n.z);
  const auto middle = [&](const float* place, std::ptrdiff_t stride) {
    return x * load(place) + y * load(place + stride) + z * load(place + 2 * stride);
  };
  const auto half = [&](const float* place, std::ptrdiff_t stride) {
    const FloatLanes along = x * load(place + 3 * stride) + y * load(place + 4 * stride) + z * load(place + 5 * stride);
    return max(along, -along);
  };
  FloatLanes low = all_floats(1e7F);
  for (int k = 0; k < arm.stride; k += kFloatLanes) {
    low =
        min(low, middle(at + k, arm.stride) - half(at + k, arm.stride) - load(arm.radius + k) + load(arm.excluded + k));
  }
  FloatLanes high = all_floats(1e7F);  // minimum of the negative
  for (int k = 0; k < other.stride; k += kFloatLanes) {
    high = min(high, load(other.padding + k) - middle(there + k, other.stride) - half(there + k, other.stride) -
                         load(other.radius + k));
  }
  return least_of(low) + least_of(high);
}

/// Distance of an arm, without its fixed bodies, to another arm [m]. An upper bound if it is below `enough`. `nearest`:
/// body checked first, and output: the nearest body. `n`: output, set if the distance is at least `enough`.
inline float rough_distance(const RoughArm& arm, const float* at, const RoughArm& other, const float* there,
                            float enough, int& nearest, RoughNormal& n) {
  constexpr float kNothing = 1e6F;
  float least = kNothing;
  RoughGaps best;
  const auto check = [&](int i, bool all) {
    const RoughBody body(at, arm.stride, i);
    for (int from = 0; from < other.stride; from += kFloatLanes) {
      if (!all && !rough_may_be_near(arm, body, i, other, there, from, least)) continue;
      const RoughGaps gaps = rough_gaps(arm, body, i, other, there, from);
      const float distance = least_of(gaps.distance);
      if (distance >= least) continue;
      least = distance;
      nearest = i;
      best = gaps;
    }
  };
  if (arm.bodies == arm.fixed) return least;
  const int before = nearest;
  check(before, true);
  for (int i = arm.bodies - 1; i >= arm.fixed && least >= enough; --i) {
    if (i != before) check(i, false);
  }
  if (least < enough || least == kNothing) return least;
  const int lane = std::countr_zero(bits(best.distance <= all_floats(least)));
  n = {best.x[lane], best.y[lane], best.z[lane]};
  const float length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  n = {n.x / length, n.y / length, n.z / length};
  return least;
}

}  // namespace hecaton::planner::HECATON_ISA
