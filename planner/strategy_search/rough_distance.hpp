#pragma once
/// Distances of two arms in single precision, eight capsules at a time: they never decide where rounding could matter,
/// so that what is simulated is the same to the last bit.

#include <bit>

#include "planner/strategy_search/flat_kernels.hpp"

namespace hecaton::planner::HECATON_ISA {

/// Where an arm's capsules are in one configuration, in W: of each coordinate of their segments' middles, then of the
/// ways from there to an end, the bodies in lanes [m]; rough_numbers() floats. What fills a group up is far away.
struct RoughPlace {
  alignas(32) float numbers[kRoughMost];
};

/// What an arm's capsules are, bodies in lanes.
struct RoughArm {
  alignas(32) float length2[kFlatBodies] = {};   ///< of half a segment, squared [m²]
  alignas(32) float inverse2[kFlatBodies] = {};  ///< 1/length2, 0 for a point [1/m²]
  alignas(32) float radius[kFlatBodies] = {};    ///< [m]
  alignas(32) float reach[kFlatBodies] = {};     ///< FlatBody's
  /// Beyond everything for what is no body, and for bodies that never move: 0 for all others.
  alignas(32) float nothing[kFlatBodies] = {};
  alignas(32) float at_rest[kFlatBodies] = {};
  int fixed = 0;
  int bodies = 0;
  std::ptrdiff_t stride = 0;  ///< from one coordinate to the next in a RoughPlace: groups of eight, filled up

  void begin(const FlatArm& arm) {
    fixed = arm.fixed;
    bodies = arm.bodies;
    stride = rough_numbers(arm) / 6;
    constexpr float kBeyond = 1e7F;
    for (int i = arm.bodies; i < kFlatBodies; ++i) nothing[i] = at_rest[i] = kBeyond;
    for (int i = 0; i < arm.fixed; ++i) at_rest[i] = kBeyond;
    for (int i = 0; i < arm.bodies; ++i) {
      const FlatBody& body = arm.body[i];
      length2[i] = static_cast<float>(body.inverse2 > 0.0 ? 0.25 / body.inverse2 : 0.0);
      inverse2[i] = static_cast<float>(4.0 * body.inverse2);
      radius[i] = static_cast<float>(body.radius);
      reach[i] = static_cast<float>(body.reach);
    }
  }
};

/// Four lanes of four configurations become four bodies of each.
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

/// Each of the four configurations by itself.
inline void round_places(const FlatArm& arm, const FourPlaces& places, float* const* rough) {
  constexpr double kFarAway = 1e6;
  const std::ptrdiff_t stride = rough_numbers(arm) / 6;
  const auto put = [&](int from, int axis, Lanes Point::*coordinate) {
    Lanes p[kLanes];
    Lanes d[kLanes];
    for (int k = 0; k < kLanes; ++k) {
      const bool is = from + k < arm.bodies;
      p[k] = is ? places.middle[from + k].*coordinate : four(kFarAway);
      d[k] = is ? four(0.5) * places.d[from + k].*coordinate : four(0.0);
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

/// One body of an arm, in all lanes.
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

/// Below this share of |d|²|d'|² the determinant is rounding, mostly: either way |gap|² is off by at most so much |d|².
inline constexpr float kParallel = 1e-6F;

struct RoughGaps {
  FloatLanes distance;  ///< [m]
  FloatLanes x, y, z;   ///< from the other's segments to this one's [m]
};

/// Distances of body i of an arm to eight bodies of another. As segment_distance2, but from the middles, with
/// parameters from −1 to 1; where segments are nearly parallel the first hardly matters.
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

/// Whether any of eight bodies may be nearer to body i than `limit` more than the balls that hold them.
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

/// A direction in W: what lies between two arms.
struct RoughNormal {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
};

/// How far apart planes across n are between which an arm (fixed bodies left out) and another have nothing [m]: no more
/// than their distance. n points towards the first; its length is 1, or 0: then it is no more than 0.
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
        min(low, middle(at + k, arm.stride) - half(at + k, arm.stride) - load(arm.radius + k) + load(arm.at_rest + k));
  }
  FloatLanes high = all_floats(1e7F);  // the other way round: of its negative, the least
  for (int k = 0; k < other.stride; k += kFloatLanes) {
    high = min(high, load(other.nothing + k) - middle(there + k, other.stride) - half(there + k, other.stride) -
                         load(other.radius + k));
  }
  return least_of(low) + least_of(high);
}

/// Distance of an arm to another, fixed bodies of the first left out [m]. Below `enough` only that it is at most so
/// much. `nearest` is the body that is looked at first, and told: most often balls rule out the rest. `n` is told where
/// the distance is `enough`.
inline float rough_distance(const RoughArm& arm, const float* at, const RoughArm& other, const float* there,
                            float enough, int& nearest, RoughNormal& n) {
  constexpr float kNothing = 1e6F;
  float least = kNothing;
  RoughGaps best;
  const auto look = [&](int i, bool all) {
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
  look(before, true);
  for (int i = arm.bodies - 1; i >= arm.fixed && least >= enough; --i) {
    if (i != before) look(i, false);
  }
  if (least < enough || least == kNothing) return least;
  const int lane = std::countr_zero(bits(best.distance <= all_floats(least)));
  n = {best.x[lane], best.y[lane], best.z[lane]};
  const float length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  n = {n.x / length, n.y / length, n.z / length};
  return least;
}

}  // namespace hecaton::planner::HECATON_ISA
