#include "planner/collision/primitive_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hecaton::planner {
namespace {

using Eigen::Vector3d;

/// Parameter in [0, 1] of the point of p + t d that is nearest to x.
double nearest_parameter(const Vector3d& p, const Vector3d& d, const Vector3d& x) {
  const double length2 = d.squaredNorm();
  return length2 > 0.0 ? std::clamp((x - p).dot(d) / length2, 0.0, 1.0) : 0.0;
}

/// A direction normal to both segments, pointing from the middle of a to that of b.
Vector3d common_normal(const Vector3d& u, const Vector3d& v, const Vector3d& between) {
  Vector3d n = u.cross(v);
  if (n.squaredNorm() <= 1e-16 * u.squaredNorm() * v.squaredNorm()) {
    const Vector3d& axis = u.squaredNorm() >= v.squaredNorm() ? u : v;
    if (axis.squaredNorm() == 0.0) return Vector3d::UnitZ();
    n = between - axis * (axis.dot(between) / axis.squaredNorm());
    if (n.squaredNorm() <= 1e-16 * axis.squaredNorm()) n = axis.unitOrthogonal();
  }
  n.normalize();
  return n.dot(between) < 0.0 ? Vector3d(-n) : n;
}

/// What sticks out of the box: x − clamp(x). Zero inside.
Vector3d excess(const Vector3d& x, const Vector3d& h) {
  return x - x.cwiseMin(h).cwiseMax(-h);
}

/// Minimises the squared distance of p + t d to the box around the origin over t in [0, 1]: its derivative is monotone
/// and linear between the parameters where the line crosses a face plane.
double nearest_parameter_to_box(const Vector3d& p, const Vector3d& d, const Vector3d& h) {
  const auto slope = [&](double t) { return d.dot(excess(p + t * d, h)); };
  double low = 0.0;
  double high = 1.0;
  double slope_low = slope(low);
  double slope_high = slope(high);
  if (slope_low >= 0.0) return low;
  if (slope_high <= 0.0) return high;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0.0) continue;
    for (const double face : {-h[axis], h[axis]}) {
      const double t = (face - p[axis]) / d[axis];
      if (!(t > low && t < high)) continue;
      const double s = slope(t);
      (s <= 0.0 ? low : high) = t;
      (s <= 0.0 ? slope_low : slope_high) = s;
    }
  }
  return low + (high - low) * (-slope_low / (slope_high - slope_low));
}

/// Direction n (from the segment towards the box) and length of the shortest translation that parts them, by the
/// separating axes of their Minkowski difference: its faces are normal to box axes or to (box edge × segment).
struct Penetration {
  Vector3d n;
  double depth;  ///< negative: that far apart along n
};

Penetration least_penetration(const Vector3d& p, const Vector3d& q, const Vector3d& h) {
  const Vector3d middle = 0.5 * (p + q);
  const Vector3d half = 0.5 * (q - p);
  Penetration least{Vector3d::UnitZ(), 0.0};
  bool found = false;
  const auto consider = [&](const Vector3d& axis, double preference) {
    const double depth = h.dot(axis.cwiseAbs()) + std::abs(half.dot(axis)) - std::abs(middle.dot(axis));
    if (found && depth + preference >= least.depth) return;
    least = {middle.dot(axis) > 0.0 ? Vector3d(-axis) : axis, depth};
    found = true;
  };
  for (int i = 0; i < 3; ++i) consider(Vector3d::Unit(i), 0.0);
  for (int i = 0; i < 3; ++i) {
    const Vector3d cross = Vector3d::Unit(i).cross(half);
    // A cross product that nearly vanishes, or nearly repeats a face normal, adds only noise.
    if (cross.squaredNorm() > 1e-16 * half.squaredNorm()) consider(cross.normalized(), 1e-12);
  }
  return least;
}

}  // namespace

ShapeDistance segment_segment(const Segment& a, const Segment& b) {
  const Vector3d u = a.q_W - a.p_W;
  const Vector3d v = b.q_W - b.p_W;
  const Vector3d w = a.p_W - b.p_W;
  double best = std::numeric_limits<double>::infinity();
  double best_s = 0.0;
  double best_t = 0.0;
  const auto consider = [&](double s, double t) {
    const double distance2 = (w + s * u - t * v).squaredNorm();
    if (distance2 >= best) return;
    best = distance2;
    best_s = s;
    best_t = t;
  };
  // The minimum lies in the inside of both, or at an end of one. Trying every end keeps parallel segments exact.
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double uv = u.dot(v);
  const double determinant = uu * vv - uv * uv;
  if (determinant > 1e-14 * uu * vv) {
    const double s = (uv * v.dot(w) - vv * u.dot(w)) / determinant;
    if (s > 0.0 && s < 1.0) {
      const double t = nearest_parameter(b.p_W, v, a.p_W + s * u);
      consider(nearest_parameter(a.p_W, u, b.p_W + t * v), t);
    }
  }
  consider(0.0, nearest_parameter(b.p_W, v, a.p_W));
  consider(1.0, nearest_parameter(b.p_W, v, a.q_W));
  consider(nearest_parameter(a.p_W, u, b.p_W), 0.0);
  consider(nearest_parameter(a.p_W, u, b.q_W), 1.0);

  ShapeDistance result;
  result.p_a_W = a.p_W + best_s * u;
  const Vector3d gap = b.p_W + best_t * v - result.p_a_W;
  result.distance = gap.norm();
  if (result.distance > kTouching) {
    result.n_W = gap / result.distance;
  } else {
    // Lines that cross: any common normal parts them, and their sweeps, by the shortest way.
    result.n_W = common_normal(u, v, 0.5 * (b.p_W + b.q_W - a.p_W - a.q_W));
    result.distance = 0.0;
  }
  result.p_b_W = result.p_a_W + result.distance * result.n_W;
  return result;
}

ShapeDistance segment_box(const Segment& a, const Vector3d& half_extents, const world::Pose& X_WS) {
  const auto R_SW = X_WS.linear().transpose();
  const Vector3d p = R_SW * (a.p_W - X_WS.translation());
  const Vector3d q = R_SW * (a.q_W - X_WS.translation());
  const Vector3d d = q - p;
  Vector3d x = p + nearest_parameter_to_box(p, d, half_extents) * d;
  const Vector3d out = excess(x, half_extents);
  ShapeDistance result;
  result.distance = out.norm();
  Vector3d n;
  if (result.distance > kTouching) {
    n = -out / result.distance;
  } else {
    const Penetration least = least_penetration(p, q, half_extents);
    n = least.n;
    result.distance = -least.depth;
    // Pulled apart along n by a little more than the depth, the nearest points are the deepest ones.
    const Vector3d shift = (least.depth + 1e-3) * n;
    const Vector3d p_apart = p - shift;
    x = p_apart + nearest_parameter_to_box(p_apart, d, half_extents) * d + shift;
  }
  result.n_W = X_WS.linear() * n;
  result.p_a_W = X_WS * x;
  result.p_b_W = result.p_a_W + result.distance * result.n_W;
  return result;
}

ShapeDistance point_cylinder(const Vector3d& p_W, double radius, double half_length, const world::Pose& X_WS) {
  const Vector3d p = X_WS.linear().transpose() * (p_W - X_WS.translation());
  const double from_axis = std::hypot(p.x(), p.y());
  const Vector3d radial = from_axis > 0.0 ? Vector3d(p.x() / from_axis, p.y() / from_axis, 0.0) : Vector3d::UnitX();
  const Vector3d axial = p.z() >= 0.0 ? Vector3d::UnitZ() : Vector3d(-Vector3d::UnitZ());
  const double beyond_side = from_axis - radius;
  const double beyond_cap = std::abs(p.z()) - half_length;
  ShapeDistance result;
  Vector3d outward;
  const double beyond_rim = std::hypot(beyond_side, beyond_cap);
  if (beyond_side > 0.0 && beyond_cap > 0.0 && beyond_rim > kTouching) {
    outward = (beyond_side * radial + beyond_cap * axial) / beyond_rim;
    result.distance = beyond_rim;
  } else {
    outward = beyond_side > beyond_cap ? radial : axial;
    result.distance = std::max(beyond_side, beyond_cap);
  }
  result.n_W = X_WS.linear() * -outward;
  result.p_a_W = p_W;
  result.p_b_W = p_W + result.distance * result.n_W;
  return result;
}

}  // namespace hecaton::planner
