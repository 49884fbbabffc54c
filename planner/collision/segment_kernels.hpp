#pragma once
/// Distances in closed form from segments to segments and to boxes, for one pair or for one pair per lane.

#include "planner/simd/lanes.hpp"

namespace hecaton::planner::HECATON_ISA {

/// Nearest points of two cores: the one on a, and the vector from there to the one on b.
template <typename T>
struct Gap {
  Vector<T> p_a;  ///< nearest point on a [m]
  Vector<T> way;  ///< from p_a to the nearest point on b [m]
};

/// p + t d, t in [0, 1].
template <typename T>
struct SegmentOf {
  Vector<T> p;  ///< one end [m]
  Vector<T> q;  ///< the other [m], may be the same
};

/// Parameter in [0, 1] of the point of p + t d that is nearest to x.
template <typename T>
inline T nearest_parameter(const Vector<T>& p, const Vector<T>& d, const Vector<T>& x) {
  const T length2 = dot(d, d);
  const T t = clamp(dot(x - p, d) / length2, all<T>(0.0), all<T>(1.0));
  return select(length2 > all<T>(0.0), t, all<T>(0.0));
}

/// The minimum lies inside both segments, or at an end of one. Testing every end keeps parallel segments exact.
template <typename T>
inline Gap<T> segment_segment(const SegmentOf<T>& a, const SegmentOf<T>& b) {
  const T zero = all<T>(0.0);
  const T one = all<T>(1.0);
  const Vector<T> u = a.q - a.p;
  const Vector<T> v = b.q - b.p;
  const Vector<T> w = a.p - b.p;

  const T uu = dot(u, u);
  const T vv = dot(v, v);
  const T uv = dot(u, v);
  const T determinant = uu * vv - uv * uv;
  const T inner_s = (uv * dot(v, w) - vv * dot(u, w)) / determinant;
  T best_t = nearest_parameter(b.p, v, a.p + inner_s * u);
  T best_s = nearest_parameter(a.p, u, b.p + best_t * v);
  const auto distance2 = [&](const T& s, const T& t) {
    const Vector<T> gap = w + s * u - t * v;
    return dot(gap, gap);
  };
  const auto crosses = both(determinant > all<T>(1e-14) * uu * vv, both(inner_s > zero, inner_s < one));
  T best = select(crosses, distance2(best_s, best_t), all<T>(HUGE_VAL));
  const auto consider = [&](const T& s, const T& t) {
    const T candidate = distance2(s, t);
    const auto better = candidate < best;
    best = select(better, candidate, best);
    best_s = select(better, s, best_s);
    best_t = select(better, t, best_t);
  };
  consider(zero, nearest_parameter(b.p, v, a.p));
  consider(one, nearest_parameter(b.p, v, a.q));
  consider(nearest_parameter(a.p, u, b.p), zero);
  consider(nearest_parameter(a.p, u, b.q), one);

  const Vector<T> p_a = a.p + best_s * u;
  return {p_a, b.p + best_t * v - p_a};
}

/// The part of x outside the box: x − clamp(x). Zero inside.
template <typename T>
inline Vector<T> excess(const Vector<T>& x, const Vector<T>& h) {
  const Vector<T> zero{};
  return x - max(min(x, h), zero - h);
}

/// b: box of half extents h around the origin. The slope of the squared distance of p + t d from it grows with t and is
/// linear between the parameters where the line crosses a face plane. Bisection at these parameters encloses its zero.
template <typename T>
inline Gap<T> segment_box(const SegmentOf<T>& a, const Vector<T>& h) {
  const T zero = all<T>(0.0);
  const T one = all<T>(1.0);
  const Vector<T> d = a.q - a.p;
  const auto slope = [&](const T& t) { return dot(d, excess(a.p + t * d, h)); };
  T low = zero;
  T high = one;
  T slope_low = slope(low);
  T slope_high = slope(high);
  const auto at_low = slope_low >= zero;
  const auto at_high = slope_high <= zero;
  const auto enclose = [&](const T& face, const T& p, const T& along) {
    const T t = (face - p) / along;  // infinite or not a number where the line runs along the face: never inside
    const auto inside = both(t > low, t < high);
    const T s = slope(t);
    const auto below = both(inside, s <= zero);
    const auto above = both(inside, s > zero);
    low = select(below, t, low);
    slope_low = select(below, s, slope_low);
    high = select(above, t, high);
    slope_high = select(above, s, slope_high);
  };
  enclose(zero - h.x, a.p.x, d.x);
  enclose(h.x, a.p.x, d.x);
  enclose(zero - h.y, a.p.y, d.y);
  enclose(h.y, a.p.y, d.y);
  enclose(zero - h.z, a.p.z, d.z);
  enclose(h.z, a.p.z, d.z);
  T t = low + (high - low) * (zero - slope_low / (slope_high - slope_low));
  t = select(at_low, zero, select(at_high, one, t));
  const Vector<T> x = a.p + t * d;
  return {x, Vector<T>{} - excess(x, h)};
}

}  // namespace hecaton::planner::HECATON_ISA
