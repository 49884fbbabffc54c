#pragma once
/// From a collision mesh to the shape that the planner uses for it.

#include <string>

#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"
#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner {

/// Hulls of robot links keep no more vertices than this: more cost time in every distance, and buy less than a
/// millimetre.
inline constexpr int kMaxHullVertices = 64;

struct MeshShape {
  LinkGeometry geometry;  ///< link not set; X_LS is the shape in the mesh's frame
  std::string note;       ///< what was simplified, empty if nothing
};

/// A convex shape that encloses the mesh in file `path` times `scale`. Throws ModelError that begins with `where`.
[[nodiscard]] MeshShape mesh_shape(const std::string& path, const Eigen::Vector3d& scale, MeshGeometry kind,
                                   const std::string& where, SourceFiles& sources);

}  // namespace hecaton::planner
