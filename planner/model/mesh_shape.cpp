#include "planner/model/mesh_shape.hpp"

#include <cmath>

#include "planner/model/convex_hull.hpp"
#include "planner/model/enclosing_capsule.hpp"
#include "planner/model/enclosing_hull.hpp"
#include "planner/model/mesh_loader.hpp"

namespace hecaton::planner {
namespace {

std::string percent(double fraction) {
  return std::to_string(std::lround(100.0 * fraction)) + " %";
}

}  // namespace

MeshShape mesh_shape(const std::string& path, const Eigen::Vector3d& scale, MeshGeometry kind,
                     const std::string& where) {
  const std::vector<Eigen::Vector3d> vertices = load_mesh_vertices(path, scale, where);
  const auto hull = convex_hull(vertices);
  if (!hull) throw ModelError(where + ": mesh '" + path + "' has no volume; a collision mesh must not be flat");

  MeshShape result;
  LinkGeometry& geometry = result.geometry;
  const double hull_volume = volume(*hull);
  if (kind == MeshGeometry::kCapsule) {
    const PlacedCapsule placed = enclosing_capsule(hull->vertices);
    geometry.shape = placed.capsule;
    geometry.X_LS = placed.X_FS;
    geometry.excess_volume = volume(placed.capsule) / hull_volume - 1.0;
    result.note = where + ": an enclosing capsule stands for mesh '" + path + "', " + percent(geometry.excess_volume) +
                  " larger than its hull";
    return result;
  }
  auto outer = std::make_shared<world::ConvexHull>(enclosing_hull(*hull, kMaxHullVertices));
  if (outer->vertices.size() != hull->vertices.size()) {
    geometry.excess_volume = volume(*outer) / hull_volume - 1.0;
    result.note = where + ": the hull of mesh '" + path + "' has " + std::to_string(hull->vertices.size()) +
                  " vertices; an enclosing polyhedron of " + std::to_string(outer->vertices.size()) + ", " +
                  percent(geometry.excess_volume) + " larger, stands for it";
  }
  geometry.shape = world::Convex{std::move(outer)};
  return result;
}

}  // namespace hecaton::planner
