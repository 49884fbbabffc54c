#pragma once
/// Triangle meshes from files (.stl, .dae, .obj). The only header-pair that includes assimp.

#include <string>
#include <vector>

#include "world/model/pose.hpp"

namespace hecaton::planner {

/// The corners of all triangles, times `scale` component by component [m]. Collada: its unit is applied, its up axis is
/// not, as ROS tools read it. Throws ModelError with `where` (the element that names the mesh) in front.
[[nodiscard]] std::vector<Eigen::Vector3d> load_mesh_vertices(const std::string& path, const Eigen::Vector3d& scale,
                                                              const std::string& where);

}  // namespace hecaton::planner
