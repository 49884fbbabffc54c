#include "planner/collision/primitive_distance.hpp"

#include <algorithm>
#include <cmath>

#include "planner/collision/segment_kernels.hpp"

namespace hecaton::planner {
namespace {

namespace kernels = HECATON_ISA;

using Eigen::Vector3d;

kernels::Vector<double> scalars(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
Vector3d vector(const kernels::Vector<double>& v) {
  return {v.x, v.y, v.z};
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

/// Direction n (from the segment towards the box) and length of the shortest translation that separates them, by the
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

/// The way from a cylinder's nearest point to a point outside, both in the cylinder's frame.
struct Outward {
  Vector3d radial;  ///< unit, across the axis
  double beyond_side;
  double beyond_cap;
  double from_axis;

  Outward(const Vector3d& p, double radius, double half_length)
      : radial(Vector3d::UnitX()),
        beyond_side(0.0),
        beyond_cap(std::max(std::abs(p.z()) - half_length, 0.0)),
        from_axis(std::sqrt(p.x() * p.x() + p.y() * p.y())) {
    if (from_axis > 0.0) radial = {p.x() / from_axis, p.y() / from_axis, 0.0};
    beyond_side = std::max(from_axis - radius, 0.0);
    beyond_cap = std::copysign(beyond_cap, p.z());
  }
  [[nodiscard]] Vector3d way() const { return beyond_side * radial + beyond_cap * Vector3d::UnitZ(); }
  /// Half the second derivative of the squared distance along `d`.
  [[nodiscard]] double curvature(const Vector3d& d) const {
    const double out = radial.dot(d);
    const double across = d.x() * d.x() + d.y() * d.y() - out * out;
    double sum = 0.0;
    if (beyond_side > 0.0) sum += out * out + beyond_side / from_axis * across;
    if (beyond_cap != 0.0) sum += d.z() * d.z();
    return sum;
  }
};

/// The steps of Newton's method end when the point moves by less [m].
constexpr double kStill = 1e-12;
constexpr int kMostSteps = 60;

}  // namespace

ShapeDistance segment_segment(const Segment& a, const Segment& b) {
  const auto nearest =
      kernels::segment_segment<double>({scalars(a.p_W), scalars(a.q_W)}, {scalars(b.p_W), scalars(b.q_W)});
  ShapeDistance result;
  result.p_a_W = vector(nearest.p_a);
  const Vector3d gap = vector(nearest.way);
  result.distance = gap.norm();
  if (result.distance > kTouching) {
    result.n_W = gap / result.distance;
  } else {
    // Segments that cross: a common normal separates them, and the volumes swept along them, on the shortest way.
    result.n_W = common_normal(a.q_W - a.p_W, b.q_W - b.p_W, 0.5 * (b.p_W + b.q_W - a.p_W - a.q_W));
    result.distance = 0.0;
  }
  result.p_b_W = result.p_a_W + result.distance * result.n_W;
  return result;
}

ShapeDistance segment_box(const Segment& a, const Vector3d& half_extents, const world::Pose& X_WS) {
  const auto R_SW = X_WS.linear().transpose();
  const Vector3d p = R_SW * (a.p_W - X_WS.translation());
  const Vector3d q = R_SW * (a.q_W - X_WS.translation());
  const auto nearest = [&](const Vector3d& shift) {
    return kernels::segment_box<double>({scalars(p - shift), scalars(q - shift)}, scalars(half_extents));
  };
  const auto found = nearest(Vector3d::Zero());
  Vector3d x = vector(found.p_a);
  Vector3d n = vector(found.way);
  ShapeDistance result;
  result.distance = n.norm();
  if (result.distance > kTouching) {
    n /= result.distance;
  } else {
    const Penetration least = least_penetration(p, q, half_extents);
    n = least.n;
    result.distance = -least.depth;
    // After a shift along n by slightly more than the depth, the nearest points are the deepest ones.
    const Vector3d shift = (least.depth + 1e-3) * n;
    x = vector(nearest(shift).p_a) + shift;
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

// The squared distance of a point from a convex body is convex, so that along the segment its derivative has one root.
// Newton's method finds it between two bounds, which close in by half when a step leaves them.
std::optional<ShapeDistance> segment_cylinder_apart(const Segment& a, double radius, double half_length,
                                                    const world::Pose& X_WS, double least) {
  const auto R_SW = X_WS.linear().transpose();
  const Vector3d p = R_SW * (a.p_W - X_WS.translation());
  const Vector3d d = R_SW * (a.q_W - a.p_W);
  const double length = d.norm();
  const auto outward = [&](double t) { return Outward(p + t * d, radius, half_length); };
  double low = 0.0;
  double high = 1.0;
  double t = 0.0;
  if (outward(0.0).way().dot(d) < 0.0) {
    t = 1.0;
    if (outward(1.0).way().dot(d) > 0.0) {
      t = std::clamp(-p.dot(d) / (length * length), 0.0, 1.0);  // nearest to the middle of the cylinder
      for (int round = 0; round < kMostSteps; ++round) {
        const Outward at = outward(t);
        const double slope = at.way().dot(d);
        if (slope == 0.0) break;
        (slope > 0.0 ? high : low) = t;
        const double curvature = at.curvature(d);
        const double step = curvature > 0.0 ? -slope / curvature : 1.0;
        if (std::abs(step) * length < kStill) break;
        const double next = t + step;
        t = next > low && next < high ? next : 0.5 * (low + high);
        if ((high - low) * length < kStill) break;
      }
    }
  }
  const Vector3d way = outward(t).way();
  const double apart = way.norm();
  if (apart <= least) return std::nullopt;
  const Vector3d n = way / apart;
  const double reach = radius * std::sqrt(n.x() * n.x() + n.y() * n.y()) + half_length * std::abs(n.z());
  ShapeDistance result;
  result.distance = std::min(n.dot(p), n.dot(p + d)) - reach;
  if (result.distance <= least) return std::nullopt;
  result.n_W = X_WS.linear() * -n;
  result.p_a_W = X_WS * (p + t * d);
  result.p_b_W = result.p_a_W + result.distance * result.n_W;
  return result;
}

}  // namespace hecaton::planner
