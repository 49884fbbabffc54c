#pragma once
/// Where a flat arm's capsules are and what they are clear of, for four configurations at a time or against four bodies
/// at a time.

#include "planner/collision/segment_kernels.hpp"
#include "planner/simd/lanes.hpp"
#include "planner/simd/sine_cosine_kernel.hpp"
#include "planner/strategy_search/run_kernel.hpp"

namespace hecaton::planner::HECATON_ISA {

using Point = Vector<Lanes>;

/// Four configurations of one arm: where each of its bodies is in them, and in which it is clear of all but other arms.
struct FourPlaces {
  Point p[kFlatBodies];
  Point d[kFlatBodies];
  unsigned alone = 0;  ///< bit k: configuration k is within limits, clear of itself and of boxes
};

inline Lanes four(double x) {
  return all<Lanes>(x);
}

/// s · x + y where most s are 0 or 1: constants of the arm, so that branches cost nothing.
inline void add_scaled(Point& sum, double s, const Point& x) {
  if (s == 0.0) return;
  sum = sum + four(s) * x;
}

inline Point constant(const double* v) {
  return {four(v[0]), four(v[1]), four(v[2])};
}

struct FourFrames {
  Point x, y, z, origin;

  [[nodiscard]] Point turned(const double* v) const {
    Point sum{};
    add_scaled(sum, v[0], x);
    add_scaled(sum, v[1], y);
    add_scaled(sum, v[2], z);
    return sum;
  }
};

/// q: of each joint, four.
inline void place(const FlatArm& arm, const Lanes* q, FourPlaces& places) {
  alignas(32) double angle[kFlatJoints * kLanes];
  alignas(32) double sine[kFlatJoints * kLanes];
  alignas(32) double cosine[kFlatJoints * kLanes];
  for (int j = 0; j < arm.joints; ++j) store(angle + kLanes * j, q[j]);
  sine_cosine(angle, kLanes * arm.joints, sine, cosine);
  for (int i = 0; i < arm.fixed; ++i) {
    places.p[i] = constant(arm.body[i].p);
    places.d[i] = constant(arm.body[i].d);
  }
  const double unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  FourFrames frame{constant(unit), constant(unit + 3), constant(unit + 6), Point{}};
  int body = arm.fixed;
  for (int j = 0; j < arm.joints; ++j) {
    const FlatJoint& joint = arm.joint[j];
    frame.origin = frame.origin + frame.turned(joint.p);
    if (joint.turned) {
      frame = {frame.turned(joint.R), frame.turned(joint.R + 3), frame.turned(joint.R + 6), frame.origin};
    }
    if (joint.slides) {
      frame.origin = frame.origin + q[j] * frame.z;
    } else {
      const Lanes s = load(sine + kLanes * j);
      const Lanes c = load(cosine + kLanes * j);
      const Point x = frame.x;
      frame.x = c * x + s * frame.y;
      frame.y = c * frame.y - s * x;
    }
    for (; body < arm.bodies && arm.body[body].joint == j; ++body) {
      places.p[body] = frame.origin + frame.turned(arm.body[body].p);
      places.d[body] = frame.turned(arm.body[body].d);
    }
  }
}

/// Squared distance of the segments p + s d and p' + t d' (s, t in [0, 1]), given 1/|d|² of each.
template <typename T>
inline T segment_distance2(const Vector<T>& p, const Vector<T>& d, const T& inverse2, const Vector<T>& p_other,
                           const Vector<T>& d_other, const T& inverse2_other) {
  const T zero = all<T>(0.0);
  const T one = all<T>(1.0);
  const Vector<T> r = p - p_other;
  const T dd = dot(d, d);
  const T oo = dot(d_other, d_other);
  const T b = dot(d, d_other);
  const T c = dot(d, r);
  const T f = dot(d_other, r);
  const T determinant = dd * oo - b * b;
  const T crossing = clamp((b * f - c * oo) / determinant, zero, one);
  const T first = select(determinant > all<T>(1e-12) * dd * oo, crossing, zero);
  const T t = clamp((b * first + f) * inverse2_other, zero, one);
  const T s = clamp((b * t - c) * inverse2, zero, one);
  const Vector<T> gap = r + s * d - t * d_other;
  return dot(gap, gap);
}

/// Bit k: in configuration k the body is nearer than `limit` to the box.
inline unsigned near_box(const FlatBox& box, const Point& p, const Point& d, double limit) {
  const Lanes reach = four(limit);
  const Point q = p + d;
  const Point low = min(p, q);
  const Point high = max(p, q);
  const LaneMask apart = (low.x - reach > four(box.high[0])) | (high.x + reach < four(box.low[0])) |
                         (low.y - reach > four(box.high[1])) | (high.y + reach < four(box.low[1])) |
                         (low.z - reach > four(box.high[2])) | (high.z + reach < four(box.low[2]));
  const unsigned candidates = ~bits(apart) & 0xFU;
  if (candidates == 0) return 0;
  const Point x = constant(box.R);
  const Point y = constant(box.R + 3);
  const Point z = constant(box.R + 6);
  const Point from = p - constant(box.c);
  const Point to = q - constant(box.c);
  const SegmentOf<Lanes> segment{{dot(from, x), dot(from, y), dot(from, z)}, {dot(to, x), dot(to, y), dot(to, z)}};
  const Gap<Lanes> gap = segment_box(segment, constant(box.half));
  return candidates & bits(dot(gap.way, gap.way) < reach * reach);
}

/// Fills places.alone.
inline void check_alone(const FlatProblem& problem, const FlatArm& arm, const Lanes* q, FourPlaces& places) {
  unsigned bad = 0;
  for (int j = 0; j < arm.joints; ++j) {
    bad |= bits((q[j] < four(arm.joint[j].lower)) | (q[j] > four(arm.joint[j].upper)));
  }
  for (int k = 0; k < arm.pairs; ++k) {
    const FlatPair& pair = arm.pair[k];
    const FlatBody& a = arm.body[pair.first];
    const FlatBody& b = arm.body[pair.second];
    const double limit = a.radius + b.radius + problem.self_distance;
    bad |= bits(segment_distance2(places.p[pair.first], places.d[pair.first], four(a.inverse2), places.p[pair.second],
                                  places.d[pair.second], four(b.inverse2)) < four(limit * limit));
  }
  for (int i = arm.fixed; i < arm.bodies; ++i) {
    const double limit = arm.body[i].radius + problem.distance;
    for (int k = 0; k < problem.boxes; ++k) bad |= near_box(problem.box[k], places.p[i], places.d[i], limit);
  }
  places.alone = ~bad & 0xFU;
}

/// Where an arm is, as others see it: its bodies in lanes. What fills the last group up is far away.
struct SeenArm {
  static constexpr double kFarAway = 1e6;
  alignas(32) double px[kFlatBodies], py[kFlatBodies], pz[kFlatBodies];
  alignas(32) double dx[kFlatBodies], dy[kFlatBodies], dz[kFlatBodies];
  alignas(32) double inverse2[kFlatBodies];
  alignas(32) double radius[kFlatBodies];
  int groups = 0;

  void begin(const FlatArm& arm) {
    groups = (arm.bodies + kLanes - 1) / kLanes;
    for (int i = 0; i < kLanes * groups; ++i) {
      const bool is = i < arm.bodies;
      px[i] = py[i] = pz[i] = is ? 0.0 : kFarAway;
      dx[i] = dy[i] = dz[i] = 0.0;
      inverse2[i] = is ? arm.body[i].inverse2 : 0.0;
      radius[i] = is ? arm.body[i].radius : 0.0;
    }
  }
  /// As it is in configuration k.
  void set(const FlatArm& arm, const FourPlaces& places, int k) {
    for (int i = 0; i < arm.bodies; ++i) {
      px[i] = places.p[i].x[k];
      py[i] = places.p[i].y[k];
      pz[i] = places.p[i].z[k];
      dx[i] = places.d[i].x[k];
      dy[i] = places.d[i].y[k];
      dz[i] = places.d[i].z[k];
    }
  }
};

/// Distance of an arm in configuration k to another arm, fixed bodies of the first left out: no motion of it changes
/// theirs [m].
inline double arm_distance(const FlatArm& arm, const FourPlaces& places, int k, const SeenArm& other) {
  Lanes least = four(SeenArm::kFarAway);
  for (int i = arm.fixed; i < arm.bodies; ++i) {
    const Point p{four(places.p[i].x[k]), four(places.p[i].y[k]), four(places.p[i].z[k])};
    const Point d{four(places.d[i].x[k]), four(places.d[i].y[k]), four(places.d[i].z[k])};
    const Lanes inverse2 = four(arm.body[i].inverse2);
    const Lanes radius = four(arm.body[i].radius);
    for (int g = 0; g < other.groups; ++g) {
      const int at = kLanes * g;
      const Point p_other{load(other.px + at), load(other.py + at), load(other.pz + at)};
      const Point d_other{load(other.dx + at), load(other.dy + at), load(other.dz + at)};
      const Lanes distance2 = segment_distance2(p, d, inverse2, p_other, d_other, load(other.inverse2 + at));
      least = min(least, sqrt(distance2) - radius - load(other.radius + at));
    }
  }
  return min(min(least[0], least[1]), min(least[2], least[3]));
}

}  // namespace hecaton::planner::HECATON_ISA
