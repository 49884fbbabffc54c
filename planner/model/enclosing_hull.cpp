#include "planner/model/enclosing_hull.hpp"

#include <algorithm>
#include <vector>

#include "planner/model/convex_hull.hpp"

namespace hecaton::planner {
namespace {

using Vertices = std::vector<Eigen::Vector3d>;

/// Corners of the intersection of half-spaces: all triples of planes, so O(m⁴), but without any topology that rounding
/// could spoil; m stays below 70.
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

/// Grows `outer` about its middle by what rounding may have cut off.
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

  // Cut off, again and again, the corner that sticks out furthest, by the face plane that cuts deepest.
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
  // The box is the fallback when the corners degenerate: it always encloses.
  auto result = convex_hull(outer);
  if (!result) {
    outer = corners({planes.begin(), planes.begin() + 6}, tolerance);
    result = convex_hull(outer);
  }
  if (!result) return hull;  // thinner than any polyhedron we accept: cannot be, `hull` has volume
  make_enclosing(*result, hull.vertices);
  return *result;
}

}  // namespace hecaton::planner
