#include "planner/model/convex_hull.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

// This order: the second header needs what the first one declares.
// clang-format off
#include <libqhull_r/libqhull_r.h>
#include <libqhull_r/poly_r.h>
// clang-format on

namespace hecaton::planner {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr double kLeastThickness = 1e-6;  // of half the extent

template <typename Measure>
const Eigen::Vector3d& furthest(const Points& points, const Measure& measure) {
  return *std::max_element(points.begin(), points.end(),
                           [&](const auto& a, const auto& b) { return measure(a) < measure(b); });
}

/// True when the points, all within [−1, 1]³, span a tetrahedron that is thick in each direction.
bool have_volume(const Points& points) {
  const Eigen::Vector3d& a = points.front();
  const Eigen::Vector3d along = furthest(points, [&](const auto& p) { return (p - a).squaredNorm(); }) - a;
  const auto area = [&](const auto& p) { return along.cross(p - a).squaredNorm(); };
  const Eigen::Vector3d normal = along.cross(furthest(points, area) - a);
  const auto height = [&](const auto& p) { return std::abs(normal.dot(p - a)); };
  return normal.norm() >= kLeastThickness * along.norm() &&
         height(furthest(points, height)) >= kLeastThickness * normal.norm();
}

/// Qhull [Barber96]. It merges faces that are coplanar up to rounding. Without its option Qt it does not triangulate
/// them: among nearly coplanar points Qt produces triangles across the hull.
class Qhull {
 public:
  explicit Qhull(Points& points) {
    // Qhull prints a page when there is no hull.
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> nowhere(std::fopen("/dev/null", "w"), std::fclose);
    qh_zero(&qh_, nowhere.get());
    char options[] = "qhull";
    error_ = qh_new_qhull(&qh_, 3, static_cast<int>(points.size()), points.front().data(), False, options, nullptr,
                          nowhere.get());
  }
  ~Qhull() {
    int kept = 0;
    int bytes = 0;
    qh_freeqhull(&qh_, !qh_ALL);
    qh_memfreeshort(&qh_, &kept, &bytes);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  [[nodiscard]] bool failed() const { return error_ != qh_ERRnone; }

  /// Indices of the points around each face, counter-clockwise from outside.
  [[nodiscard]] std::vector<std::vector<int>> faces() {
    std::vector<std::vector<int>> faces;
    for (facetT* facet = qh_.facet_list; facet != nullptr && facet->next != nullptr; facet = facet->next) {
      setT* corners = qh_facet3vertex(&qh_, facet);
      std::vector<int>& face = faces.emplace_back();
      for (int i = 0, count = qh_setsize(&qh_, corners); i < count; ++i) {
        face.push_back(qh_pointid(&qh_, static_cast<vertexT*>(corners->e[i].p)->point));
      }
      qh_settempfree(&qh_, &corners);
      std::reverse(face.begin(), face.end());
    }
    return faces;
  }

 private:
  qhT qh_ = {};
  int error_ = qh_ERRnone;
};

}  // namespace

std::optional<world::ConvexHull> convex_hull(std::span<const Eigen::Vector3d> points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) {
    if (!point.allFinite()) return std::nullopt;
    box.extend(point);
  }
  if (points.size() < 4) return std::nullopt;
  const double scale = 2.0 / box.sizes().maxCoeff();
  if (!(scale > 0.0) || !std::isfinite(scale)) return std::nullopt;

  Points scaled;
  scaled.reserve(points.size());
  for (const Eigen::Vector3d& point : points) scaled.emplace_back((point - box.center()) * scale);
  if (!have_volume(scaled)) return std::nullopt;
  Qhull qhull(scaled);
  if (qhull.failed()) return std::nullopt;
  world::ConvexHull hull;
  std::map<int, int> vertex_of;  // by index of `points`
  for (std::vector<int>& face : qhull.faces()) {
    for (int& corner : face) {
      const auto [entry, is_new] = vertex_of.try_emplace(corner, static_cast<int>(hull.vertices.size()));
      if (is_new) hull.vertices.push_back(points[corner]);
      corner = entry->second;
    }
    hull.faces.push_back(std::move(face));
  }
  return hull;
}

double volume(const world::ConvexHull& hull) {
  if (hull.vertices.empty()) return 0.0;
  const Eigen::Vector3d& origin = hull.vertices.front();
  double six_volumes = 0.0;
  for (const auto& face : hull.faces) {
    for (std::size_t i = 2; i < face.size(); ++i) {
      const Eigen::Vector3d a = hull.vertices[face[0]] - origin;
      const Eigen::Vector3d b = hull.vertices[face[i - 1]] - origin;
      six_volumes += a.dot(b.cross(hull.vertices[face[i]] - origin));
    }
  }
  return six_volumes / 6.0;
}

FacePlane face_plane(const world::ConvexHull& hull, int face) {
  const auto& corners = hull.faces[face];
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i) {
    normal += (hull.vertices[corners[i - 1]] - hull.vertices[corners[0]])
                  .cross(hull.vertices[corners[i]] - hull.vertices[corners[0]]);
  }
  normal.normalize();
  return {normal, normal.dot(hull.vertices[corners[0]])};
}

namespace {

using Vertices = std::vector<Eigen::Vector3d>;

/// Corners of the intersection of half-spaces, from all triples of planes: O(m⁴), but without a topology that rounding
/// could corrupt. m stays below 70.
Vertices corners(const std::vector<FacePlane>& planes, double tolerance) {
  Vertices found;
  const int m = static_cast<int>(planes.size());
  for (int i = 0; i < m; ++i) {
    for (int j = i + 1; j < m; ++j) {
      const Eigen::Vector3d line = planes[i].normal.cross(planes[j].normal);
      for (int k = j + 1; k < m; ++k) {
        const double determinant = line.dot(planes[k].normal);
        if (std::abs(determinant) < 1e-8) continue;
        const Eigen::Vector3d corner =
            (planes[k].offset * line + planes[i].offset * planes[j].normal.cross(planes[k].normal) +
             planes[j].offset * planes[k].normal.cross(planes[i].normal)) /
            determinant;
        const auto outside = [&](const FacePlane& plane) {
          return plane.normal.dot(corner) > plane.offset + tolerance;
        };
        const auto same = [&](const Eigen::Vector3d& other) { return (corner - other).norm() < 10.0 * tolerance; };
        if (std::any_of(planes.begin(), planes.end(), outside)) continue;
        if (std::none_of(found.begin(), found.end(), same)) found.push_back(corner);
      }
    }
  }
  return found;
}

/// Scales `outer` about its middle so that it encloses `inner` despite rounding.
void make_enclosing(world::ConvexHull& outer, const Vertices& inner) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& vertex : outer.vertices) middle += vertex / static_cast<double>(outer.vertices.size());
  double factor = 1.0;
  for (int face = 0; face < static_cast<int>(outer.faces.size()); ++face) {
    const FacePlane plane = face_plane(outer, face);
    const double reach = plane.offset - plane.normal.dot(middle);
    for (const auto& vertex : inner) factor = std::max(factor, plane.normal.dot(vertex - middle) / reach);
  }
  for (auto& vertex : outer.vertices) vertex = middle + (factor * (1.0 + 1e-9)) * (vertex - middle);
}

}  // namespace

world::ConvexHull enclosing_hull(const world::ConvexHull& hull, int most_vertices) {
  if (static_cast<int>(hull.vertices.size()) <= most_vertices) return hull;
  Eigen::AlignedBox3d box;
  for (const auto& vertex : hull.vertices) box.extend(vertex);
  const double extent = box.sizes().maxCoeff();
  const double tolerance = 1e-9 * extent;

  std::vector<FacePlane> planes;
  for (int axis = 0; axis < 3; ++axis) {
    planes.push_back({Eigen::Vector3d::Unit(axis), box.max()[axis]});
    planes.push_back({-Eigen::Vector3d::Unit(axis), -box.min()[axis]});
  }
  std::vector<FacePlane> candidates;
  candidates.reserve(hull.faces.size());
  for (int face = 0; face < static_cast<int>(hull.faces.size()); ++face) candidates.push_back(face_plane(hull, face));

  // Repeatedly cut off the corner that protrudes furthest, with the face plane that cuts deepest.
  Vertices outer = corners(planes, tolerance);
  while (true) {
    double deepest = 1e-4 * extent;
    const FacePlane* best = nullptr;
    for (const FacePlane& candidate : candidates) {
      for (const auto& corner : outer) {
        const double depth = candidate.normal.dot(corner) - candidate.offset;
        if (depth > deepest) {
          deepest = depth;
          best = &candidate;
        }
      }
    }
    if (best == nullptr) break;
    planes.push_back(*best);
    Vertices next = corners(planes, tolerance);
    if (static_cast<int>(next.size()) > most_vertices) break;
    outer = std::move(next);
  }
  // The bounding box always encloses: it is the fallback when the corners degenerate.
  auto result = convex_hull(outer);
  if (!result) {
    outer = corners({planes.begin(), planes.begin() + 6}, tolerance);
    result = convex_hull(outer);
  }
  if (!result) return hull;  // unreachable: `hull` has a volume
  make_enclosing(*result, hull.vertices);
  return *result;
}

world::Convex convex_shape(std::span<const Eigen::Vector3d> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) throw std::invalid_argument("points[" + std::to_string(i) + "] must be finite");
  }
  const auto hull = convex_hull(points);
  if (!hull) throw std::invalid_argument("a shape of " + std::to_string(points.size()) + " points has no volume");
  return {std::make_shared<const world::ConvexHull>(enclosing_hull(*hull, kMaxHullVertices))};
}

}  // namespace hecaton::planner
