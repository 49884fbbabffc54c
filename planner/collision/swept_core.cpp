#include "planner/collision/swept_core.hpp"

#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace hecaton::planner {
namespace {

constexpr std::size_t kLanes = 4;
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));
using LaneIndices = std::int64_t __attribute__((vector_size(kLanes * sizeof(std::int64_t))));

struct Coordinates {
  const double* x;
  const double* y;
  const double* z;
  std::size_t count;  // a multiple of kLanes, > 0
};

/// Always inline, because it is compiled twice: for the baseline and for AVX2. Neither uses FMA, so both round alike.
[[gnu::always_inline]] inline std::size_t scan(const Coordinates& c, double nx, double ny, double nz) {
  constexpr double kLowest = -std::numeric_limits<double>::infinity();
  Lanes best = {kLowest, kLowest, kLowest, kLowest};
  LaneIndices best_group = {0, 0, 0, 0};
  for (std::size_t i = 0; i < c.count; i += kLanes) {
    Lanes x;
    Lanes y;
    Lanes z;
    std::memcpy(&x, c.x + i, sizeof(Lanes));
    std::memcpy(&y, c.y + i, sizeof(Lanes));
    std::memcpy(&z, c.z + i, sizeof(Lanes));
    const Lanes dot = x * nx + y * ny + z * nz;
    const LaneIndices group = LaneIndices{} + static_cast<std::int64_t>(i);
    best_group = dot > best ? group : best_group;
    best = dot > best ? dot : best;
  }
  std::size_t lane = 0;
  for (std::size_t other = 1; other < kLanes; ++other) {
    if (best[other] > best[lane]) lane = other;
  }
  return static_cast<std::size_t>(best_group[lane]) + lane;
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] std::size_t scan_avx2(const Coordinates& c, double nx, double ny, double nz) {
  return scan(c, nx, ny, nz);
}
#endif

std::size_t scan_baseline(const Coordinates& c, double nx, double ny, double nz) {
  return scan(c, nx, ny, nz);
}

using Scan = std::size_t (*)(const Coordinates&, double, double, double);

Scan fastest_scan() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return scan_avx2;
#endif
  return scan_baseline;
}

const Scan chosen_scan = fastest_scan();

}  // namespace

HullVertices::HullVertices(std::span<const Eigen::Vector3d> vertices) {
  for (const auto& vertex : vertices) {
    x_.push_back(vertex.x());
    y_.push_back(vertex.y());
    z_.push_back(vertex.z());
  }
  while (x_.size() % kLanes != 0) {
    x_.push_back(x_.front());
    y_.push_back(y_.front());
    z_.push_back(z_.front());
  }
}

Eigen::Vector3d HullVertices::farthest(const Eigen::Vector3d& n) const {
  const std::size_t i = chosen_scan({x_.data(), y_.data(), z_.data(), x_.size()}, n.x(), n.y(), n.z());
  return {x_[i], y_[i], z_[i]};
}

SweptCore make_swept_core(const world::Shape& shape) {
  using Eigen::Vector3d;
  struct Visitor {
    SweptCore operator()(const world::Box& box) const {
      return {Core::kBox, 0.0, box.half_extents, Vector3d::Zero(), {}};
    }
    SweptCore operator()(const world::Sphere& sphere) const {
      return {Core::kPoint, sphere.radius, Vector3d::Zero(), Vector3d::Zero(), {}};
    }
    SweptCore operator()(const world::Capsule& capsule) const {
      return {Core::kSegment, capsule.radius, {0.0, 0.0, capsule.half_length}, Vector3d::Zero(), {}};
    }
    SweptCore operator()(const world::Cylinder& cylinder) const {
      return {Core::kCylinder, 0.0, {cylinder.radius, cylinder.radius, cylinder.half_length}, Vector3d::Zero(), {}};
    }
    SweptCore operator()(const world::Convex& convex) const {
      return {Core::kHull, 0.0, Vector3d::Zero(), world::bounding_sphere(convex).centre,
              HullVertices(convex.hull->vertices)};
    }
    SweptCore operator()(const world::Points&) const { throw std::logic_error("points have no convex core"); }
  };
  return std::visit(Visitor{}, shape);
}

}  // namespace hecaton::planner
