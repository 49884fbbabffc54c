#include "planner/global/kernel_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hecaton::planner::global {
namespace {

using world::BoundingSphere;

/// A convex polyhedron as the corners of its faces [m].
struct ConvexPolyhedron {
  std::vector<std::vector<Eigen::Vector3d>> faces;  ///< corners in order around each face

  /// Each corner once per face.
  [[nodiscard]] std::vector<Eigen::Vector3d> corners() const {
    std::vector<Eigen::Vector3d> all;
    for (const auto& face : faces) all.insert(all.end(), face.begin(), face.end());
    return all;
  }
};

/// n · x ≤ offset
struct HalfSpace {
  Eigen::Vector3d normal;  ///< unit
  double offset;           ///< [m]
};

using Loop = std::vector<Eigen::Vector3d>;

/// Newell's normal, not normalized; also for loops with collinear corners.
Eigen::Vector3d newell_normal(const Loop& loop) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    normal += (loop[i] - loop[0]).cross(loop[(i + 1) % loop.size()] - loop[0]);
  }
  return normal;
}

void order_around(Loop& loop, const Eigen::Vector3d& normal) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& p : loop) centre += p / static_cast<double>(loop.size());
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  const auto angle = [&](const Eigen::Vector3d& p) { return std::atan2(v.dot(p - centre), u.dot(p - centre)); };
  std::sort(loop.begin(), loop.end(), [&](const auto& a, const auto& b) { return angle(a) < angle(b); });
}

ConvexPolyhedron polyhedron_of(const world::Box& box) {
  ConvexPolyhedron result;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      Loop face;
      for (const auto& [a, b] : {std::pair{-1.0, -1.0}, {side, -side}, {1.0, 1.0}, {-side, side}}) {
        Eigen::Vector3d corner;
        corner[axis] = side * box.half_extents[axis];
        corner[u] = a * box.half_extents[u];
        corner[v] = b * box.half_extents[v];
        face.push_back(corner);
      }
      result.faces.push_back(std::move(face));
    }
  }
  return result;
}

ConvexPolyhedron polyhedron_of(const world::ConvexHull& hull) {
  ConvexPolyhedron result;
  for (const auto& face : hull.faces) {
    Loop& loop = result.faces.emplace_back();
    for (const int vertex : face) loop.push_back(hull.vertices[vertex]);
  }
  return result;
}

/// The half spaces whose intersection is the polyhedron.
std::vector<HalfSpace> half_spaces(const ConvexPolyhedron& polyhedron) {
  Eigen::Vector3d inside = Eigen::Vector3d::Zero();
  const Loop corners = polyhedron.corners();
  for (const auto& p : corners) inside += p / static_cast<double>(corners.size());
  std::vector<HalfSpace> result;
  for (const auto& face : polyhedron.faces) {
    Eigen::Vector3d normal = newell_normal(face);
    if (normal.norm() < 1e-14) continue;
    normal.normalize();
    if (normal.dot(face[0] - inside) < 0.0) normal = -normal;
    double offset = normal.dot(face[0]);
    for (const auto& p : corners) offset = std::max(offset, normal.dot(p));  // against rounding: all corners are inside
    const bool known = std::any_of(result.begin(), result.end(), [&](const HalfSpace& other) {
      return (other.normal - normal).norm() < 1e-9 && std::abs(other.offset - offset) < 1e-9;
    });
    if (!known) result.push_back({normal, offset});
  }
  return result;
}

/// The part of the polyhedron in the half space; no faces if there is none. The corners of the new face are ordered
/// well enough for bounding spheres only.
ConvexPolyhedron cut(const ConvexPolyhedron& polyhedron, const HalfSpace& half) {
  ConvexPolyhedron result;
  Loop opening;
  const auto over = [&](const Eigen::Vector3d& p) { return half.normal.dot(p) - half.offset; };
  for (const Loop& face : polyhedron.faces) {
    Loop kept;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Eigen::Vector3d& p = face[i];
      const Eigen::Vector3d& q = face[(i + 1) % face.size()];
      const double over_p = over(p);
      const double over_q = over(q);
      if (over_p <= 0.0) kept.push_back(p);
      if ((over_p < 0.0 && over_q > 0.0) || (over_p > 0.0 && over_q < 0.0)) {
        kept.push_back(p + (over_p / (over_p - over_q)) * (q - p));
        opening.push_back(kept.back());
      }
    }
    if (kept.size() >= 3) result.faces.push_back(std::move(kept));
  }
  if (opening.size() >= 3) {
    order_around(opening, half.normal);
    result.faces.push_back(std::move(opening));
  }
  return result;
}

/// `count` spheres along z, with centres from −last to +last.
std::vector<BoundingSphere> row(int count, double last, double radius) {
  std::vector<BoundingSphere> spheres;
  for (int i = 0; i < count; ++i) {
    const double z = count == 1 ? 0.0 : last * (2.0 * i / (count - 1) - 1.0);
    spheres.push_back({Eigen::Vector3d(0.0, 0.0, z), radius});
  }
  return spheres;
}

/// A sphere of radius R on the axis covers the capsule's surface for √(R² − r²) to either side. The outermost sphere
/// lies inside the cap's centre such that it reaches the cap's pole.
std::vector<BoundingSphere> cover(const world::Capsule& capsule, const CoverOptions& options) {
  const double r = capsule.radius;
  for (int count = 1;; ++count) {
    const auto radius_for = [&](double inset) {
      const double half_gap = count == 1 ? 0.0 : (capsule.half_length - inset) / (count - 1);
      return std::max(std::hypot(r, half_gap), r + inset);
    };
    double inset = count == 1 ? capsule.half_length : 0.0;
    if (count > 1) {  // solve r + inset = √(r² + half_gap²): the left side grows, the right side falls
      double low = 0.0;
      double high = capsule.half_length;
      for (int i = 0; i < 60; ++i) {
        inset = 0.5 * (low + high);
        (std::hypot(r, (capsule.half_length - inset) / (count - 1)) > r + inset ? low : high) = inset;
      }
    }
    const double radius = radius_for(inset);
    if (radius <= r + options.excess || count >= options.max_spheres)
      return row(count, capsule.half_length - inset, radius);
  }
}

std::vector<BoundingSphere> cover(const world::Cylinder& cylinder, const CoverOptions& options) {
  const double half_gap = std::sqrt(std::pow(cylinder.radius + options.excess, 2) - std::pow(cylinder.radius, 2));
  const int count = std::clamp(static_cast<int>(std::ceil(cylinder.half_length / half_gap)), 1, options.max_spheres);
  const double half_slice = cylinder.half_length / count;
  return row(count, cylinder.half_length - half_slice, std::hypot(cylinder.radius, half_slice));
}

struct Piece {
  ConvexPolyhedron polyhedron;
  BoundingSphere sphere;
  double excess = 0.0;  ///< of the sphere beyond the faces of the whole shape [m]
};

Piece make_piece(ConvexPolyhedron polyhedron, const std::vector<HalfSpace>& faces) {
  Piece piece{std::move(polyhedron), {}, 0.0};
  piece.sphere = bounding_sphere_of(piece.polyhedron.corners());
  for (const HalfSpace& face : faces) {
    piece.excess = std::max(piece.excess, face.normal.dot(piece.sphere.centre) + piece.sphere.radius - face.offset);
  }
  return piece;
}

/// Cuts the piece in half across the axis that gives the smaller spheres.
std::pair<Piece, Piece> halves(const Piece& piece, const std::vector<HalfSpace>& faces) {
  Eigen::AlignedBox3d extent;
  for (const auto& p : piece.polyhedron.corners()) extent.extend(p);
  std::pair<Piece, Piece> best;
  double least = HUGE_VAL;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d normal = Eigen::Vector3d::Unit(axis);
    const double middle = extent.center()[axis];
    std::pair<Piece, Piece> two{make_piece(cut(piece.polyhedron, {normal, middle}), faces),
                                make_piece(cut(piece.polyhedron, {-normal, -middle}), faces)};
    const double largest = std::max(two.first.sphere.radius, two.second.sphere.radius);
    if (largest < least) {
      least = largest;
      best = std::move(two);
    }
  }
  return best;
}

std::vector<BoundingSphere> cover(const ConvexPolyhedron& whole, const CoverOptions& options) {
  const std::vector<HalfSpace> faces = half_spaces(whole);
  std::vector<Piece> pieces{make_piece(whole, faces)};
  while (static_cast<int>(pieces.size()) < options.max_spheres) {
    const auto worst = std::max_element(pieces.begin(), pieces.end(),
                                        [](const Piece& a, const Piece& b) { return a.excess < b.excess; });
    if (worst->excess <= options.excess) break;
    auto [first, second] = halves(*worst, faces);
    *worst = std::move(first);
    pieces.push_back(std::move(second));
  }
  std::vector<BoundingSphere> spheres;
  for (const Piece& piece : pieces) spheres.push_back(piece.sphere);
  return spheres;
}

/// Share of the largest coordinate that rounding to float may cost, of an obstacle and of what touches it.
constexpr double kWorldRounding = 2.5e-6;
/// Sides of boxes that no link meets [m].
constexpr float kNowhere = 3e37F;
/// Axes this close to those of O are equal to them. It leaves out less than the rounding.
constexpr double kSnap = 1e-9;
/// Links are tested with obstacles beyond their reach and padding by this [m], for edges with clearance.
constexpr double kMargin = 0.1;

/// Axis-aligned box of a shape at X_OS [m].
struct Extent {
  Eigen::Vector3d centre;
  Eigen::Vector3d half;
};

Extent extent_of(const world::Shape& shape, const world::Pose& X_OS) {
  const Eigen::Matrix3d size = X_OS.linear().cwiseAbs();
  const Eigen::Vector3d z = size.col(2);
  struct Visitor {
    const world::Pose& X_OS;
    const Eigen::Matrix3d& size;
    const Eigen::Vector3d& z;
    Extent operator()(const world::Box& box) const { return {X_OS.translation(), size * box.half_extents}; }
    Extent operator()(const world::Sphere& sphere) const {
      return {X_OS.translation(), Eigen::Vector3d::Constant(sphere.radius)};
    }
    Extent operator()(const world::Capsule& capsule) const {
      return {X_OS.translation(), z * capsule.half_length + Eigen::Vector3d::Constant(capsule.radius)};
    }
    Extent operator()(const world::Cylinder& cylinder) const {
      const Eigen::Vector3d across = (Eigen::Vector3d::Ones() - z.cwiseProduct(z)).cwiseMax(0.0).cwiseSqrt();
      return {X_OS.translation(), z * cylinder.half_length + across * cylinder.radius};
    }
    Extent operator()(const world::Convex& convex) const {
      Eigen::AlignedBox3d box;
      for (const auto& vertex : convex.hull->vertices) box.extend(X_OS * vertex);
      return {box.center(), box.sizes() / 2.0};
    }
    Extent operator()(const world::Points& points) const {
      const world::PointBox& box = points.cloud->box();
      const Eigen::Vector3d half = 0.5 * (to_vector(box.high) - to_vector(box.low));
      return {X_OS * points.cloud->centre(), size * half + Eigen::Vector3d::Constant(points.cloud->radius())};
    }
    static Eigen::Vector3d to_vector(const float (&v)[3]) {
      return Eigen::Map<const Eigen::Vector3f>(v).cast<double>();
    }
  };
  return std::visit(Visitor{X_OS, size, z}, shape);
}

struct ObstacleMaker {
  KernelWorld& world;
  const world::Pose& X_OS;
  double rounding;  ///< [m]
  KernelObstacle obstacle;

  void half(double x, double y, double z) {
    obstacle.half = {static_cast<float>(x + rounding), static_cast<float>(y + rounding),
                     static_cast<float>(z + rounding)};
  }
  void operator()(const world::Box& box) {
    obstacle.kind = ObstacleKind::kBox;
    half(box.half_extents.x(), box.half_extents.y(), box.half_extents.z());
    std::array<float, 3> aligned{};
    for (int k = 0; k < 3; ++k) {
      int axis = 0;
      if (X_OS.linear().col(k).cwiseAbs().maxCoeff(&axis) < 1.0 - kSnap) return;
      aligned[axis] = obstacle.half[k];
    }
    obstacle.kind = ObstacleKind::kAlignedBox;
    obstacle.half = aligned;
  }
  void operator()(const world::Sphere& sphere) {
    obstacle.kind = ObstacleKind::kBall;
    obstacle.radius = static_cast<float>(sphere.radius + rounding);
  }
  void operator()(const world::Capsule& capsule) {
    obstacle.kind = ObstacleKind::kCapsule;
    half(0.0, 0.0, capsule.half_length);
    obstacle.radius = static_cast<float>(capsule.radius + rounding);
  }
  void operator()(const world::Cylinder& cylinder) {
    obstacle.kind = ObstacleKind::kCylinder;
    half(cylinder.radius, 0.0, cylinder.half_length);
  }
  void operator()(const world::Convex& convex) {
    obstacle.kind = ObstacleKind::kConvex;
    obstacle.first = static_cast<int>(world.planes.size());
    for (const HalfSpace& face : half_spaces(polyhedron_of(*convex.hull))) {
      const Eigen::Vector3d normal = X_OS.linear() * face.normal;
      KernelPlane& plane = world.planes.emplace_back();
      for (int k = 0; k < 3; ++k) plane.normal[k] = static_cast<float>(normal[k]);
      plane.offset = static_cast<float>(face.offset + normal.dot(X_OS.translation()) + rounding);
    }
    obstacle.count = static_cast<int>(world.planes.size()) - obstacle.first;
  }
  /// The kernel moves links into the frame of the cloud, whose coordinates are rounded, too.
  void operator()(const world::Points& points) {
    obstacle.kind = ObstacleKind::kPoints;
    const double largest = points.cloud->centre().norm() + points.cloud->bounding_radius() + X_OS.translation().norm();
    obstacle.radius = static_cast<float>(points.cloud->radius() + rounding + kWorldRounding * largest);
    obstacle.nodes = points.cloud->nodes().data();
    obstacle.leaves = points.cloud->leaves().data();
  }
};

}  // namespace

BoundingSphere bounding_sphere_of(const std::vector<Eigen::Vector3d>& points) {
  BoundingSphere sphere;
  if (points.empty()) return sphere;
  Eigen::AlignedBox3d box;
  for (const auto& p : points) box.extend(p);
  sphere.centre = box.center();
  const auto farthest = [&] {
    return *std::max_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
      return (a - sphere.centre).squaredNorm() < (b - sphere.centre).squaredNorm();
    });
  };
  // Bădoiu and Clarkson: steps towards the farthest point, each shorter than the last.
  for (int i = 2; i < 200; ++i) sphere.centre += (farthest() - sphere.centre) / i;
  sphere.radius = (farthest() - sphere.centre).norm();
  return sphere;
}

std::vector<BoundingSphere> sphere_cover(const world::Shape& shape, const CoverOptions& options) {
  struct Visitor {
    const CoverOptions& options;
    std::vector<BoundingSphere> operator()(const world::Box& box) const { return cover(polyhedron_of(box), options); }
    std::vector<BoundingSphere> operator()(const world::Sphere& sphere) const {
      return {{Eigen::Vector3d::Zero(), sphere.radius}};
    }
    std::vector<BoundingSphere> operator()(const world::Capsule& capsule) const { return cover(capsule, options); }
    std::vector<BoundingSphere> operator()(const world::Cylinder& cylinder) const { return cover(cylinder, options); }
    std::vector<BoundingSphere> operator()(const world::Convex& convex) const {
      return cover(polyhedron_of(*convex.hull), options);
    }
    std::vector<BoundingSphere> operator()(const world::Points& points) const {
      return {world::bounding_sphere(points)};
    }
  };
  return std::visit(Visitor{options}, shape);
}

KernelWorld kernel_world(std::span<const WorldBody> bodies, const world::Pose& X_OW, double padding,
                         std::span<const BoundingSphere> reach_of_link) {
  KernelWorld world;
  world.padding = static_cast<float>(padding);
  world.margin = static_cast<float>(kMargin);
  std::vector<Extent> extents;
  for (const WorldBody& body : bodies) {
    const world::Pose X_OS = X_OW * body.X_WS;
    Extent extent = extent_of(body.shape, X_OS);
    const double rounding = kWorldRounding * (0.1 + (extent.centre.cwiseAbs() + extent.half).maxCoeff());
    ObstacleMaker maker{world, X_OS, rounding, {}};
    for (int k = 0; k < 9; ++k) maker.obstacle.axes[k] = static_cast<float>(X_OS.linear()(k % 3, k / 3));
    for (int k = 0; k < 3; ++k) maker.obstacle.centre[k] = static_cast<float>(X_OS.translation()[k]);
    for (int k = 0; k < 3; ++k) {
      maker.obstacle.along[k] = static_cast<float>(X_OS.linear().col(k).dot(X_OS.translation()));
    }
    std::visit(maker, body.shape);
    world.obstacles.push_back(maker.obstacle);
    extent.half.array() += 2.0 * rounding + (maker.obstacle.kind == ObstacleKind::kPoints ? kWorldRounding : 0.0) *
                                                (extent.centre.norm() + extent.half.norm());
    extents.push_back(extent);
  }
  const auto add_boxes = [&](std::vector<KernelBoxes>& boxes, const auto& wanted) {
    int place = kTablePadding;
    for (int i = 0; i < static_cast<int>(extents.size()); ++i) {
      if (!wanted(extents[i])) continue;
      if (place == kTablePadding) {
        place = 0;
        for (auto& side : boxes.emplace_back().low) side.fill(kNowhere);
        for (auto& side : boxes.back().high) side.fill(kNowhere);
      }
      for (int k = 0; k < 3; ++k) {
        boxes.back().low[k][place] = static_cast<float>(extents[i].centre[k] - extents[i].half[k]);
        boxes.back().high[k][place] = static_cast<float>(extents[i].centre[k] + extents[i].half[k]);
      }
      boxes.back().obstacle[place++] = i;
    }
  };
  add_boxes(world.all, [](const Extent&) { return true; });
  for (const BoundingSphere& reach : reach_of_link) {
    world.boxes_of_link.push_back(static_cast<int>(world.boxes.size()));
    add_boxes(world.boxes, [&](const Extent& extent) {
      const Eigen::Vector3d away = (reach.centre - extent.centre).cwiseAbs() - extent.half;
      return away.cwiseMax(0.0).norm() <= reach.radius + padding + kMargin;
    });
  }
  world.boxes_of_link.push_back(static_cast<int>(world.boxes.size()));
  return world;
}

}  // namespace hecaton::planner::global
