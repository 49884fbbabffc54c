#pragma once
/// Collision meshes (.stl, .dae, .obj) and the convex shapes that the planner uses for them. mesh_shape.cpp is the only
/// source that includes assimp.

#include <string>

#include "planner/model/convex_hull.hpp"
#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"
#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner {

struct MeshShape {
  LinkGeometry geometry;  ///< link not set; X_LS is the shape in the mesh's frame
  std::string note;       ///< what the shape simplifies; empty: nothing
};

/// A convex shape that encloses the mesh in the file `path`, scaled component by component. Collada files: the unit
/// applies, the up axis does not, as in ROS tools. Throws ModelError that begins with `where`, the element that names
/// the mesh.
[[nodiscard]] MeshShape mesh_shape(const std::string& path, const Eigen::Vector3d& scale, MeshGeometry kind,
                                   const std::string& where, SourceFiles& sources);

}  // namespace hecaton::planner
