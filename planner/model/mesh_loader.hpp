#pragma once
/// Triangle meshes from files (.stl, .dae, .obj). The only header-pair that includes assimp.

#include <optional>
#include <string>
#include <vector>

#include "planner/model/source_file.hpp"
#include "world/model/pose.hpp"

namespace hecaton::planner {

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;  ///< the corners of all triangles [m]
  std::optional<double> volume;           ///< [m³]; empty when its surface is not closed
};

/// Times `scale` component by component. Collada: its unit is applied, its up axis is not, as ROS tools read it. Throws
/// ModelError with `where` (the element that names the mesh) in front.
[[nodiscard]] Mesh load_mesh(const std::string& path, const Eigen::Vector3d& scale, const std::string& where,
                             SourceFiles& sources);

}  // namespace hecaton::planner
