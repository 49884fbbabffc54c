#pragma once
/// Any serial arm from its URDF, at run time. The only header-pair that includes urdfdom.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planner/model/model_error.hpp"
#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// How collision meshes become shapes.
enum class MeshGeometry {
  kConvexHull,  ///< the hull of all vertices
  kCapsule,     ///< a capsule that encloses the hull; its excess volume is reported
};

struct UrdfOptions {
  std::string tool_link;         ///< empty: the last link of the only (or longest) chain
  Pose X_LT = Pose::Identity();  ///< tool frame in the tool link's frame
  std::string srdf_path;         ///< empty: no SRDF
  std::map<std::string, std::string>
      packages;  ///< package:// name → folder; else the URDF's ancestors, ROS_PACKAGE_PATH
  MeshGeometry meshes = MeshGeometry::kConvexHull;
  double default_acceleration = 10.0;      ///< URDF knows none [rad/s² | m/s²]
  std::optional<double> default_velocity;  ///< for joints whose limit is 0 or missing; without it they are an error
  SourceFiles* sources = nullptr;          ///< where its files are read from; null: from where they are
  bool allow_bare_links = false;           ///< accept bodies that a joint moves but that have no collision geometry

  /// What whoever reads the messages calls the two options above ("arms[0].limits.velocity"); empty: not offered.
  std::string name_of_default_velocity;
  std::string name_of_allow_bare_links;
};

/// Loads `urdf_path`. Throws ModelError.
[[nodiscard]] std::shared_ptr<const RobotModel> load_urdf(const std::string& urdf_path,
                                                          const UrdfOptions& options = {});

}  // namespace hecaton::planner
