#include "planner/model/capsules.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Eigenvalues>

#include "planner/model/convex_hull.hpp"

namespace hecaton::planner {
namespace {

using Points2 = std::vector<Eigen::Vector2d>;

struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = -1.0;
  [[nodiscard]] bool holds(const Eigen::Vector2d& p) const {
    return (p - centre).norm() <= radius * (1.0 + 1e-12) + 1e-15;
  }
};

Circle through(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {(a + b) / 2.0, (a - b).norm() / 2.0};
}

Circle through(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d u = b - a;
  const Eigen::Vector2d v = c - a;
  const double twice_area = u.x() * v.y() - u.y() * v.x();
  if (std::abs(twice_area) < 1e-14 * u.norm() * v.norm()) {  // on one line: the longest side is the diameter
    Circle widest = through(a, b);
    for (const Circle& other : {through(b, c), through(a, c)}) {
      if (other.radius > widest.radius) widest = other;
    }
    return widest;
  }
  const Eigen::Vector2d centre = Eigen::Vector2d(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(),
                                                 u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) /
                                 (2.0 * twice_area);
  return {a + centre, centre.norm()};
}

/// [Welzl91] The smallest enclosing circle, in its iterative form; `points` in random order for linear expected time.
Circle smallest_circle(const Points2& points) {
  Circle circle{points.front(), 0.0};
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (circle.holds(points[i])) continue;
    circle = {points[i], 0.0};
    for (std::size_t j = 0; j < i; ++j) {
      if (circle.holds(points[j])) continue;
      circle = through(points[i], points[j]);
      for (std::size_t k = 0; k < j; ++k) {
        if (!circle.holds(points[k])) circle = through(points[i], points[j], points[k]);
      }
    }
  }
  for (const auto& point : points) circle.radius = std::max(circle.radius, (point - circle.centre).norm());
  return circle;
}

/// The capsule along `axis` with the smallest radius, as short as that radius allows.
PlacedCapsule capsule_along(const Eigen::Vector3d& axis, std::span<const Eigen::Vector3d> points) {
  const Eigen::Vector3d x = axis.unitOrthogonal();
  const Eigen::Vector3d y = axis.cross(x);
  Points2 projected;
  projected.reserve(points.size());
  for (const auto& p : points) projected.emplace_back(p.dot(x), p.dot(y));
  const Circle circle = smallest_circle(projected);
  const double radius = circle.radius * (1.0 + 1e-9) + 1e-12;
  double top = -std::numeric_limits<double>::infinity();  // of the segment: its cap reaches every point above
  double bottom = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off_axis = (projected[i] - circle.centre).norm();
    const double cap = std::sqrt(std::max(0.0, radius * radius - off_axis * off_axis));
    const double t = points[i].dot(axis);
    top = std::max(top, t - cap);
    bottom = std::min(bottom, t + cap);
  }
  if (top < bottom) top = bottom = (top + bottom) / 2.0;  // a ball suffices, its centre anywhere between
  PlacedCapsule result{{radius, (top - bottom) / 2.0}, world::Pose::Identity()};
  result.X_FS.linear().col(0) = x;
  result.X_FS.linear().col(1) = y;
  result.X_FS.linear().col(2) = axis;
  result.X_FS.translation() = circle.centre.x() * x + circle.centre.y() * y + (top + bottom) / 2.0 * axis;
  return result;
}

/// Of the points' scatter, the longest last.
Eigen::Matrix3d principal_axes(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& p : points) scatter += (p - mean) * (p - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors();
}

/// The smallest capsule of radius R along z around two rims of `radius` at z = ±half_length. Its caps bulge over the
/// rims by √(R² − radius²): a wider capsule is shorter.
world::Capsule capsule_around_rims(double radius, double half_length) {
  const auto bulging = [&](double bulge) {
    return world::Capsule{std::hypot(radius, bulge), std::max(0.0, half_length - bulge)};
  };
  double low = 0.0;
  double high = half_length;
  constexpr int kRounds = 60;  // of ternary search: down to 3·10⁻¹¹ of the length
  for (int round = 0; round < kRounds; ++round) {
    const double third = (high - low) / 3.0;
    if (volume(bulging(low + third)) < volume(bulging(high - third))) {
      high -= third;
    } else {
      low += third;
    }
  }
  return bulging(low);
}

/// `capsule` with its axis along coordinate axis `k`.
PlacedCapsule along_axis(const world::Capsule& capsule, int k) {
  PlacedCapsule placed{capsule, world::Pose::Identity()};
  for (int i = 0; i < 3; ++i) placed.X_FS.linear().col(i) = Eigen::Vector3d::Unit((k + 1 + i) % 3);
  return placed;
}

}  // namespace

PlacedCapsule bounding_capsule(const world::Shape& shape) {
  struct Visitor {
    PlacedCapsule operator()(const world::Sphere& sphere) const { return {world::Capsule{sphere.radius, 0.0}}; }
    PlacedCapsule operator()(const world::Capsule& capsule) const { return {capsule}; }
    PlacedCapsule operator()(const world::Cylinder& cylinder) const {
      return {capsule_around_rims(cylinder.radius, cylinder.half_length)};
    }
    PlacedCapsule operator()(const world::Box& box) const {
      Eigen::Index longest = 0;
      const double half_length = box.half_extents.maxCoeff(&longest);
      const double rim = std::hypot(box.half_extents[(longest + 1) % 3], box.half_extents[(longest + 2) % 3]);
      return along_axis(capsule_around_rims(rim, half_length), static_cast<int>(longest));
    }
    PlacedCapsule operator()(const world::Convex& convex) const {
      const auto& vertices = convex.hull->vertices;
      return capsule_along(principal_axes(vertices).col(2).normalized(), vertices);
    }
    PlacedCapsule operator()(const world::Points& points) const {
      return {world::Capsule{points.cloud->bounding_radius(), 0.0},
              world::Pose(Eigen::Translation3d(points.cloud->centre()))};
    }
  };
  return std::visit(Visitor{}, shape);
}

double volume(const world::Capsule& capsule) {
  const double area = std::numbers::pi * capsule.radius * capsule.radius;
  return area * (2.0 * capsule.half_length + 4.0 / 3.0 * capsule.radius);
}

PlacedCapsule enclosing_capsule(std::span<const Eigen::Vector3d> given) {
  std::vector<Eigen::Vector3d> points(given.begin(), given.end());
  std::shuffle(points.begin(), points.end(), std::mt19937(1));  // for smallest_circle; the seed keeps it repeatable
  const Eigen::Matrix3d principal = principal_axes(points);

  Eigen::Vector3d best_axis = Eigen::Vector3d::UnitZ();
  PlacedCapsule best = capsule_along(best_axis, points);
  const auto try_axis = [&](const Eigen::Vector3d& axis) {
    const PlacedCapsule candidate = capsule_along(axis, points);
    if (!(volume(candidate.capsule) < volume(best.capsule))) return false;
    best = candidate;
    best_axis = axis;
    return true;
  };
  try_axis(Eigen::Vector3d::UnitX());
  try_axis(Eigen::Vector3d::UnitY());
  for (int i = 0; i < 3; ++i) try_axis(principal.col(i).normalized());
  for (double step = 0.2; step > 1e-3;) {  // pattern search on the sphere of directions [rad]
    const Eigen::Vector3d u = best_axis.unitOrthogonal();
    const Eigen::Vector3d v = best_axis.cross(u);
    bool improved = false;
    for (const Eigen::Vector3d& side : {u, v, Eigen::Vector3d(-u), Eigen::Vector3d(-v)}) {
      improved = improved || try_axis((best_axis + step * side).normalized());
    }
    if (!improved) step *= 0.5;
  }
  return best;
}

double volume(const world::Shape& shape) {
  struct Visitor {
    double operator()(const world::Box& box) const { return 8.0 * box.half_extents.prod(); }
    double operator()(const world::Sphere& sphere) const { return volume(world::Capsule{sphere.radius, 0.0}); }
    double operator()(const world::Capsule& capsule) const { return volume(capsule); }
    double operator()(const world::Cylinder& cylinder) const {
      return 2.0 * std::numbers::pi * cylinder.radius * cylinder.radius * cylinder.half_length;
    }
    double operator()(const world::Convex& convex) const { return volume(*convex.hull); }
    double operator()(const world::Points& points) const {
      return (*this)(world::Sphere{points.cloud->bounding_radius()});
    }
  };
  return std::visit(Visitor{}, shape);
}

std::optional<LinkCapsule> link_capsule(const world::Shape& shape) {
  if (std::holds_alternative<world::Sphere>(shape) || std::holds_alternative<world::Capsule>(shape)) return {};
  const auto* convex = std::get_if<world::Convex>(&shape);
  const PlacedCapsule placed = convex != nullptr ? enclosing_capsule(convex->hull->vertices) : bounding_capsule(shape);
  const double times = volume(placed.capsule) / volume(shape);
  if (times > kMostCapsuleVolume) return {};
  return LinkCapsule{placed, times - 1.0};
}

namespace {

constexpr double kSame = 1e-5;  // [m], the rounding error of decimals in a URDF

/// Index of an unused sphere of `radius` at `centre`; −1: none.
int sphere_at(const std::vector<world::PlacedShape>& shapes, const std::vector<bool>& used,
              const Eigen::Vector3d& centre, double radius) {
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto* sphere = std::get_if<world::Sphere>(&shapes[i].shape);
    if (sphere != nullptr && !used[i] && std::abs(sphere->radius - radius) < kSame &&
        (shapes[i].X_BS.translation() - centre).norm() < kSame) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

}  // namespace

std::vector<world::PlacedShape> merge_capsules(const std::vector<world::PlacedShape>& shapes) {
  std::vector<world::PlacedShape> merged = shapes;
  std::vector<bool> used(shapes.size(), false);  // spheres that became caps
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto* cylinder = std::get_if<world::Cylinder>(&shapes[i].shape);
    if (cylinder == nullptr || cylinder->half_length < kSame) continue;
    const Eigen::Vector3d to_top(0.0, 0.0, cylinder->half_length);
    const int top = sphere_at(shapes, used, shapes[i].X_BS * to_top, cylinder->radius);
    const int bottom = sphere_at(shapes, used, shapes[i].X_BS * -to_top, cylinder->radius);
    if (top < 0 || bottom < 0) continue;
    used[top] = used[bottom] = true;
    merged[i].shape = world::Capsule{cylinder->radius, cylinder->half_length};
  }
  std::vector<world::PlacedShape> result;
  for (std::size_t i = 0; i < merged.size(); ++i) {
    if (!used[i]) result.push_back(merged[i]);
  }
  return result;
}

}  // namespace hecaton::planner
