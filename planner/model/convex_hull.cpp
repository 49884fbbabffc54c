#include "planner/model/convex_hull.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <vector>

namespace hecaton::planner {
namespace {

// [Barber96] Quickhull on an integer grid: every orientation test is exact, so coplanar and nearly coplanar points need
// no tolerances and the topology is always that of a convex polyhedron. Differences of coordinates need 27 bits, cross
// products 56, their products with differences 85.
__extension__ using Wide = __int128;
using GridPoint = Eigen::Matrix<std::int64_t, 3, 1>;
constexpr double kGridHalfWidth = 1 << 26;
constexpr double kLeastThickness = 1e-6;  // of the extent

struct Face {
  std::array<int, 3> corners;     // counter-clockwise from outside
  std::array<int, 3> neighbours;  // across the edge corners[i] → corners[i + 1]
  GridPoint normal;
  std::vector<int> outside;  // points strictly above this face
  bool removed = false;
};

class Quickhull {
 public:
  /// Points sorted lexicographically, without duplicates. Ties are then broken by the larger index: the result's
  /// vertices are all corners, none lies within an edge or a face.
  explicit Quickhull(std::vector<GridPoint> points) : points_(std::move(points)) {}

  bool build() {
    if (points_.size() < 4 || !start()) return false;
    while (!pending_.empty()) {
      const int face = pending_.back();
      pending_.pop_back();
      if (!faces_[face].removed && !faces_[face].outside.empty()) add_point(face);
    }
    return true;
  }

  [[nodiscard]] std::vector<std::array<int, 3>> triangles() const {
    std::vector<std::array<int, 3>> result;
    for (const Face& face : faces_) {
      if (!face.removed) result.push_back(face.corners);
    }
    return result;
  }

 private:
  [[nodiscard]] Wide height(const Face& face, int point) const {
    const GridPoint d = points_[point] - points_[face.corners[0]];
    return Wide{face.normal[0]} * d[0] + Wide{face.normal[1]} * d[1] + Wide{face.normal[2]} * d[2];
  }

  int add_face(int a, int b, int c) {
    Face face;
    face.corners = {a, b, c};
    face.neighbours = {-1, -1, -1};
    face.normal = (points_[b] - points_[a]).cross(points_[c] - points_[a]);
    faces_.push_back(std::move(face));
    return static_cast<int>(faces_.size()) - 1;
  }

  template <typename Measure>
  int furthest(Measure measure) const {
    int best = 0;
    for (int i = 1; i < static_cast<int>(points_.size()); ++i) {
      if (measure(i) >= measure(best)) best = i;
    }
    return best;
  }

  bool start() {
    const int a = 0;
    const Eigen::Vector3d origin = points_[a].cast<double>();
    const int b = furthest([&](int i) { return (points_[i].cast<double>() - origin).squaredNorm(); });
    const Eigen::Vector3d along = points_[b].cast<double>() - origin;
    const int c = furthest([&](int i) { return along.cross(points_[i].cast<double>() - origin).squaredNorm(); });
    const double thinnest = kLeastThickness * kGridHalfWidth;
    const Eigen::Vector3d across = along.cross(points_[c].cast<double>() - origin);
    if (across.norm() < thinnest * along.norm()) return false;

    const int base = add_face(a, b, c);
    const int d = furthest([&](int i) { return std::abs(static_cast<double>(height(faces_[base], i))); });
    const Wide above = height(faces_[base], d);
    if (std::abs(static_cast<double>(above)) < thinnest * across.norm()) return false;
    faces_.clear();
    const std::array<int, 4> v = above < 0 ? std::array{a, b, c, d} : std::array{a, c, b, d};
    add_face(v[0], v[1], v[2]);
    add_face(v[0], v[3], v[1]);
    add_face(v[1], v[3], v[2]);
    add_face(v[2], v[3], v[0]);
    faces_[0].neighbours = {1, 2, 3};
    faces_[1].neighbours = {3, 2, 0};
    faces_[2].neighbours = {1, 3, 0};
    faces_[3].neighbours = {2, 1, 0};

    std::vector<int> everything(points_.size());
    std::iota(everything.begin(), everything.end(), 0);
    distribute(everything, {0, 1, 2, 3});
    return true;
  }

  void distribute(const std::vector<int>& points, const std::vector<int>& faces) {
    for (const int point : points) {
      for (const int face : faces) {
        if (height(faces_[face], point) > 0) {
          faces_[face].outside.push_back(point);
          break;
        }
      }
    }
    for (const int face : faces) {
      if (!faces_[face].outside.empty()) pending_.push_back(face);
    }
  }

  [[nodiscard]] int apex_of(const Face& face) const {
    int apex = face.outside.front();
    Wide highest = height(face, apex);
    for (const int point : face.outside) {
      const Wide candidate = height(face, point);
      if (candidate > highest || (candidate == highest && point > apex)) {
        highest = candidate;
        apex = point;
      }
    }
    return apex;
  }

  void add_point(int seen_from) {
    const int apex = apex_of(faces_[seen_from]);
    struct HorizonEdge {
      int to;
      int beyond;  // the face that stays
    };
    std::map<int, HorizonEdge> horizon;  // by start corner: the horizon of an exact hull is one simple cycle
    std::vector<int> orphans;
    std::vector<int> visible{seen_from};
    faces_[seen_from].removed = true;
    for (std::size_t i = 0; i < visible.size(); ++i) {
      Face& face = faces_[visible[i]];
      orphans.insert(orphans.end(), face.outside.begin(), face.outside.end());
      face.outside.clear();
      for (int edge = 0; edge < 3; ++edge) {
        const int neighbour = face.neighbours[edge];
        if (faces_[neighbour].removed) continue;
        if (height(faces_[neighbour], apex) > 0) {
          faces_[neighbour].removed = true;
          visible.push_back(neighbour);
        }
      }
    }
    for (const int index : visible) {
      const Face& face = faces_[index];
      for (int edge = 0; edge < 3; ++edge) {
        if (!faces_[face.neighbours[edge]].removed) {
          horizon[face.corners[edge]] = {face.corners[(edge + 1) % 3], face.neighbours[edge]};
        }
      }
    }

    std::map<int, int> face_from;  // new face by the start corner of its horizon edge
    for (const auto& [from, edge] : horizon) {
      const int created = add_face(from, edge.to, apex);
      face_from[from] = created;
      Face& beyond = faces_[edge.beyond];
      for (int i = 0; i < 3; ++i) {
        if (beyond.corners[i] == edge.to && beyond.corners[(i + 1) % 3] == from) beyond.neighbours[i] = created;
      }
    }
    std::vector<int> created;
    for (const auto& [from, face] : face_from) {
      const HorizonEdge& edge = horizon.at(from);
      const int next = face_from.at(edge.to);
      faces_[face].neighbours[0] = edge.beyond;
      faces_[face].neighbours[1] = next;
      faces_[next].neighbours[2] = face;
      created.push_back(face);
    }
    distribute(orphans, created);
  }

  std::vector<GridPoint> points_;
  std::vector<Face> faces_;
  std::vector<int> pending_;
};

}  // namespace

std::optional<world::ConvexHull> convex_hull(std::span<const Eigen::Vector3d> points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) {
    if (!point.allFinite()) return std::nullopt;
    box.extend(point);
  }
  if (points.size() < 4) return std::nullopt;
  const double half_width = 0.5 * box.sizes().maxCoeff();
  const double scale = kGridHalfWidth / half_width;
  if (!(half_width > 0.0) || !std::isfinite(scale)) return std::nullopt;

  std::vector<std::pair<GridPoint, int>> grid;  // and the point it stands for
  grid.reserve(points.size());
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    const Eigen::Vector3d p = (points[i] - box.center()) * scale;
    grid.emplace_back(GridPoint(std::llround(p[0]), std::llround(p[1]), std::llround(p[2])), i);
  }
  const auto less = [](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.first.begin(), a.first.end(), b.first.begin(), b.first.end());
  };
  std::stable_sort(grid.begin(), grid.end(), less);
  grid.erase(std::unique(grid.begin(), grid.end(), [](const auto& a, const auto& b) { return a.first == b.first; }),
             grid.end());
  std::vector<GridPoint> sorted;
  sorted.reserve(grid.size());
  for (const auto& [point, index] : grid) sorted.push_back(point);

  Quickhull quickhull(std::move(sorted));
  if (!quickhull.build()) return std::nullopt;
  world::ConvexHull hull;
  std::map<int, int> vertex_of;
  for (const auto& triangle : quickhull.triangles()) {
    std::vector<int> face;
    for (const int corner : triangle) {
      const auto [entry, is_new] = vertex_of.try_emplace(corner, static_cast<int>(hull.vertices.size()));
      if (is_new) hull.vertices.push_back(points[grid[corner].second]);
      face.push_back(entry->second);
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
