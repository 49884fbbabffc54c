#pragma once
/// Places of an arm's capsules in four configurations at a time, and their distances, against four bodies at a time.

#include "planner/collision/segment_kernels.hpp"
#include "planner/simd/lanes.hpp"
#include "planner/simd/sine_cosine.hpp"
#include "planner/strategy_search/run_kernel.hpp"

namespace hecaton::planner::HECATON_ISA {

using Point = Vector<Lanes>;

/// Four configurations of one arm: the segments of its bodies in W.
struct FourPlaces {
  Point p[kFlatBodies];
  Point d[kFlatBodies];
  Point middle[kFlatBodies];  ///< midpoint of the segment
  unsigned self_free = 0;     ///< bit k: configuration k is within limits, clear of itself and of boxes
};

inline Lanes four(double x) {
  return all<Lanes>(x);
}

/// sum += s · x. Most s are constants 0, so the branch is well predicted.
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

/// q: by joint, four values.
inline void place(const FlatArm& arm, const Lanes* q, FourPlaces& places) {
  alignas(32) double angle[kFlatJoints * kLanes];
  alignas(32) double sine[kFlatJoints * kLanes];
  alignas(32) double cosine[kFlatJoints * kLanes];
  for (int j = 0; j < arm.joints; ++j) store(angle + std::ptrdiff_t{kLanes} * j, q[j]);
  sine_cosine(angle, kLanes * arm.joints, sine, cosine);
  for (int i = 0; i < arm.fixed; ++i) {
    places.p[i] = constant(arm.body[i].p);
    places.d[i] = constant(arm.body[i].d);
    places.middle[i] = places.p[i] + four(0.5) * places.d[i];
  }
  const double unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  FourFrames frame{constant(unit), constant(unit + 3), constant(unit + 6), Point{}};
  int body = arm.fixed;
  for (int j = 0; j < arm.joints; ++j) {
    const FlatJoint& joint = arm.joint[j];
    frame.origin = frame.origin + frame.turned(joint.p);
    if (joint.rotated) {
      frame = {frame.turned(joint.R), frame.turned(joint.R + 3), frame.turned(joint.R + 6), frame.origin};
    }
    if (joint.prismatic) {
      frame.origin = frame.origin + q[j] * frame.z;
    } else {
      const Lanes s = load(sine + std::ptrdiff_t{kLanes} * j);
      const Lanes c = load(cosine + std::ptrdiff_t{kLanes} * j);
      const Point x = frame.x;
      frame.x = c * x + s * frame.y;
      frame.y = c * frame.y - s * x;
    }
    for (; body < arm.bodies && arm.body[body].joint == j; ++body) {
      places.p[body] = frame.origin + frame.turned(arm.body[body].p);
      places.d[body] = frame.turned(arm.body[body].d);
      places.middle[body] = places.p[body] + four(0.5) * places.d[body];
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

inline constexpr unsigned kAllLanes = 0xFU;

/// Bit k: in configuration k, the box from `low` to `high`, enlarged by `reach`, overlaps the other box.
inline unsigned overlap(const Point& low, const Point& high, const Lanes& reach, const double* other_low,
                        const double* other_high) {
  const LaneMask apart = (low.x - reach > four(other_high[0])) | (high.x + reach < four(other_low[0])) |
                         (low.y - reach > four(other_high[1])) | (high.y + reach < four(other_low[1])) |
                         (low.z - reach > four(other_high[2])) | (high.z + reach < four(other_low[2]));
  return ~bits(apart) & kAllLanes;
}

/// Bit k, if set in `candidates`: in configuration k, the body is nearer than `reach` to the box.
inline unsigned near_box(const FlatBox& box, const Point& p, const Point& q, const Lanes& reach, unsigned candidates) {
  const Point x = constant(box.R);
  const Point y = constant(box.R + 3);
  const Point z = constant(box.R + 6);
  const Point from = p - constant(box.c);
  const Point to = q - constant(box.c);
  const SegmentOf<Lanes> segment{{dot(from, x), dot(from, y), dot(from, z)}, {dot(to, x), dot(to, y), dot(to, z)}};
  const Gap<Lanes> gap = segment_box(segment, constant(box.half));
  return candidates & bits(dot(gap.way, gap.way) < reach * reach);
}

/// Bit k: in configuration k, the body is nearer than h to a box.
inline unsigned near_boxes(const FlatProblem& problem, const FlatBody& body, const Point& p, const Point& d) {
  const Lanes reach = four(body.radius + problem.distance);
  const Point q = p + d;
  const Point low = min(p, q);
  const Point high = max(p, q);
  unsigned near = 0;
  for (int k = 0; body.boxes >> k != 0; ++k) {
    if ((body.boxes >> k & 1U) == 0) continue;
    const FlatBox& box = problem.box[k];
    const unsigned candidates = overlap(low, high, reach, box.low, box.high) & ~near;
    if (candidates != 0) near |= near_box(box, p, q, reach, candidates);
  }
  return near;
}

/// Upper bound of the rounding error of bounding spheres [m].
inline constexpr double kRounding = 1e-9;
/// True if the centres of two bounding spheres are within `limit` in any lane.
inline unsigned may_be_near(const Point& middle, const Point& other, const Lanes& limit) {
  const Point apart = middle - other;
  return bits(dot(apart, apart) < limit * limit);
}

/// Fills places.self_free.
inline void check_self_free(const FlatProblem& problem, const FlatArm& arm, const Lanes* q, FourPlaces& places) {
  unsigned bad = 0;
  for (int j = 0; j < arm.joints; ++j) {
    bad |= bits((q[j] < four(arm.joint[j].lower)) | (q[j] > four(arm.joint[j].upper)));
  }
  for (int i = arm.fixed; i < arm.bodies && bad != kAllLanes; ++i) {
    if (arm.body[i].boxes != 0) bad |= near_boxes(problem, arm.body[i], places.p[i], places.d[i]);
  }
  for (int k = 0; k < arm.pairs && bad != kAllLanes; ++k) {
    const FlatPair& pair = arm.pair[k];
    const FlatBody& a = arm.body[pair.first];
    const FlatBody& b = arm.body[pair.second];
    const double bound = a.reach + b.reach + problem.self_distance + kRounding;
    if (may_be_near(places.middle[pair.first], places.middle[pair.second], four(bound)) == 0) continue;
    const double limit = a.radius + b.radius + problem.self_distance;
    bad |= bits(segment_distance2(places.p[pair.first], places.d[pair.first], four(a.inverse2), places.p[pair.second],
                                  places.d[pair.second], four(b.inverse2)) < four(limit * limit));
  }
  places.self_free = ~bad & kAllLanes;
}

/// An arm's bodies in lanes, as the other side of a distance. Padding lanes are far away.
struct SeenArm {
  static constexpr double kFarAway = 1e6;
  alignas(32) double px[kFlatBodies], py[kFlatBodies], pz[kFlatBodies];
  alignas(32) double dx[kFlatBodies], dy[kFlatBodies], dz[kFlatBodies];
  alignas(32) double mx[kFlatBodies], my[kFlatBodies], mz[kFlatBodies];  ///< midpoints
  alignas(32) double reach[kFlatBodies];                                 ///< FlatBody::reach
  alignas(32) double inverse2[kFlatBodies];
  alignas(32) double radius[kFlatBodies];
  int groups = 0;

  void begin(const FlatArm& arm) {
    groups = (arm.bodies + kLanes - 1) / kLanes;
    for (int i = 0; i < kLanes * groups; ++i) {
      const bool used = i < arm.bodies;
      px[i] = py[i] = pz[i] = used ? 0.0 : kFarAway;
      mx[i] = my[i] = mz[i] = px[i];
      reach[i] = used ? arm.body[i].reach : 0.0;
      dx[i] = dy[i] = dz[i] = 0.0;
      inverse2[i] = used ? arm.body[i].inverse2 : 0.0;
      radius[i] = used ? arm.body[i].radius : 0.0;
    }
  }
  /// Copies configuration k.
  void set(const FlatArm& arm, const FourPlaces& places, int k) {
    for (int i = 0; i < arm.bodies; ++i) {
      px[i] = places.p[i].x[k];
      py[i] = places.p[i].y[k];
      pz[i] = places.p[i].z[k];
      dx[i] = places.d[i].x[k];
      dy[i] = places.d[i].y[k];
      dz[i] = places.d[i].z[k];
      mx[i] = places.middle[i].x[k];
      my[i] = places.middle[i].y[k];
      mz[i] = places.middle[i].z[k];
    }
  }
};

inline double least_of(const Lanes& x) {
  return min(min(x[0], x[1]), min(x[2], x[3]));
}

/// A body of one arm, and a group of four of another.
struct NearestBodies {
  int body = -1;
  int group = 0;
};

/// Distance of one body to a group of others [m].
inline double body_distance(const FlatArm& arm, const FourPlaces& places, int k, const SeenArm& other, int i, int g) {
  const int at = kLanes * g;
  const Point p{four(places.p[i].x[k]), four(places.p[i].y[k]), four(places.p[i].z[k])};
  const Point d{four(places.d[i].x[k]), four(places.d[i].y[k]), four(places.d[i].z[k])};
  const Point p_other{load(other.px + at), load(other.py + at), load(other.pz + at)};
  const Point d_other{load(other.dx + at), load(other.dy + at), load(other.dz + at)};
  const Lanes distance2 =
      segment_distance2(p, d, four(arm.body[i].inverse2), p_other, d_other, load(other.inverse2 + at));
  return least_of(sqrt(distance2) - four(arm.body[i].radius) - load(other.radius + at));
}

/// Distance of an arm in configuration k to another arm [m], without the fixed bodies of the first. An upper bound if
/// it is below `enough`. `nearest`: input, checked first, so that bounding spheres exclude most of the rest; output:
/// the nearest.
inline double arm_distance(const FlatArm& arm, const FourPlaces& places, int k, const SeenArm& other, double enough,
                           NearestBodies& nearest) {
  const NearestBodies before = nearest;
  double least = SeenArm::kFarAway;
  if (before.body >= 0) {
    least = body_distance(arm, places, k, other, before.body, before.group);
    if (least < enough) return least;
  }
  for (int i = arm.bodies - 1; i >= arm.fixed; --i) {
    const Point middle{four(places.middle[i].x[k]), four(places.middle[i].y[k]), four(places.middle[i].z[k])};
    const double reach = arm.body[i].reach + kRounding;
    for (int g = other.groups - 1; g >= 0; --g) {
      if (i == before.body && g == before.group) continue;
      const int at = kLanes * g;
      const Point middle_other{load(other.mx + at), load(other.my + at), load(other.mz + at)};
      if (may_be_near(middle, middle_other, four(least + reach) + load(other.reach + at)) == 0) continue;
      const double distance = body_distance(arm, places, k, other, i, g);
      if (distance >= least) continue;
      least = distance;
      nearest = {i, g};
      if (least < enough) return least;
    }
  }
  return least;
}

}  // namespace hecaton::planner::HECATON_ISA
