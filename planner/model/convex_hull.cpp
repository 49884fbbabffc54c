#include "planner/model/convex_hull.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
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

/// Whether the points span a tetrahedron that is thick in each direction. Within [−1, 1]³.
bool have_volume(const Points& points) {
  const Eigen::Vector3d& a = points.front();
  const Eigen::Vector3d along = furthest(points, [&](const auto& p) { return (p - a).squaredNorm(); }) - a;
  const auto area = [&](const auto& p) { return along.cross(p - a).squaredNorm(); };
  const Eigen::Vector3d normal = along.cross(furthest(points, area) - a);
  const auto height = [&](const auto& p) { return std::abs(normal.dot(p - a)); };
  return normal.norm() >= kLeastThickness * along.norm() &&
         height(furthest(points, height)) >= kLeastThickness * normal.norm();
}

/// Qhull [Barber96]. Faces that are coplanar but for rounding are merged; to cut them into triangles is not asked for
/// (its option Qt): among nearly coplanar points that gave triangles across the hull.
class Qhull {
 public:
  explicit Qhull(Points& points) {
    // Where there is no hull, Qhull prints a page about it.
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

}  // namespace hecaton::planner
