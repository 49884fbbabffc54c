#include "planner/model/mesh_shape.hpp"

#include <algorithm>
#include <cmath>

#include "planner/model/convex_hull.hpp"
#include "planner/model/enclosing_capsule.hpp"
#include "planner/model/enclosing_hull.hpp"
#include "planner/model/mesh_loader.hpp"

namespace hecaton::planner {
namespace {

/// A mesh that fills this much of its hull is convex, but for rounding.
constexpr double kConvex = 0.999;

std::string percent(double fraction) {
  return std::to_string(std::lround(100.0 * fraction)) + " %";
}

}  // namespace

MeshShape mesh_shape(const std::string& path, const Eigen::Vector3d& scale, MeshGeometry kind, const std::string& where,
                     SourceFiles& sources) {
  const Mesh mesh = load_mesh(path, scale, where, sources);
  const auto hull = convex_hull(mesh.vertices);
  if (!hull) throw ModelError(where + ": mesh '" + path + "' has no volume; a collision mesh must not be flat");

  MeshShape result;
  LinkGeometry& geometry = result.geometry;
  const double hull_volume = volume(*hull);
  // Rounding can make the hull of a convex mesh the smaller one.
  const double mesh_volume = std::min(mesh.volume.value_or(hull_volume), hull_volume);
  const std::string of_what = mesh.volume ? "the mesh" : "its hull, for the mesh is not closed";
  const auto stands_for = [&](const std::string& what, double shape_volume) {
    geometry.excess_volume = shape_volume / mesh_volume - 1.0;
    result.note = where + ": " + what + " stands for mesh '" + path + "', " + percent(geometry.excess_volume) +
                  " larger than " + of_what;
  };
  if (kind == MeshGeometry::kCapsule) {
    const PlacedCapsule placed = enclosing_capsule(hull->vertices);
    geometry.shape = placed.capsule;
    geometry.X_LS = placed.X_FS;
    stands_for("an enclosing capsule", volume(placed.capsule));
    return result;
  }
  auto outer = std::make_shared<world::ConvexHull>(enclosing_hull(*hull, kMaxHullVertices));
  if (outer->vertices.size() != hull->vertices.size()) {
    stands_for("an enclosing polyhedron of " + std::to_string(outer->vertices.size()) + " vertices", volume(*outer));
  } else if (mesh_volume < kConvex * hull_volume) {
    stands_for("the convex hull", hull_volume);
  }
  geometry.shape = world::Convex{std::move(outer)};
  return result;
}

}  // namespace hecaton::planner
