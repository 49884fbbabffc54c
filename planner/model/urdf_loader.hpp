#pragma once
/// Loads a serial arm from its URDF at run time. urdf_loader.cpp is the only source that includes urdfdom.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// How collision meshes become shapes.
enum class MeshGeometry {
  kConvexHull,  ///< the hull of all vertices
  kCapsule,     ///< a capsule that encloses the hull; a note reports its excess volume
};

struct UrdfOptions {
  std::string tool_link;                        ///< empty: the last link of the only (or longest) chain
  Pose X_LT = Pose::Identity();                 ///< tool frame in the tool link's frame
  std::string srdf_path;                        ///< empty: no SRDF
  std::map<std::string, std::string> packages;  ///< package:// name → folder, searched first: resolve_resource()
  MeshGeometry meshes = MeshGeometry::kConvexHull;
  /// For all joints, because URDF has none [rad/s² | m/s²]; empty: assumed_acceleration().
  std::optional<double> default_acceleration = 10.0;
  std::optional<double> default_velocity;  ///< for joints whose limit is 0 or missing; empty: these are an error
  SourceFiles* sources = nullptr;          ///< opens the files; null: in place
  bool allow_bare_links = false;           ///< accepts moving bodies without collision geometry

  /// How messages name these two options to the user ("arms[0].limits.velocity"); empty: the user has no such option.
  std::string name_of_default_velocity;
  std::string name_of_allow_bare_links;
};

/// Loads the arm and applies its SRDF. Self pairs are not filtered yet: automatic_filter(). Throws ModelError.
[[nodiscard]] std::shared_ptr<const RobotModel> load_urdf(const std::string& urdf_path,
                                                          const UrdfOptions& options = {});

}  // namespace hecaton::planner
