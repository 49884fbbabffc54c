#pragma once
/// Loads a serial arm from its URDF at run time. urdf_loader.cpp is the only source that includes urdfdom.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planner/model/followers.hpp"
#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// How collision meshes become shapes.
enum class MeshGeometry {
  kConvexHull,  ///< the hull of all vertices
  kCapsule,     ///< a capsule that encloses the hull; a note reports its excess volume
};

/// How messages name options to the user ("--tool LINK", "arms[0].limits.velocity"); empty: the user has no such
/// option.
struct UrdfOptionNames {
  std::string tool_link;  ///< may have @first and @second for the links of equal chains
  std::string packages;   ///< with @ for the name of the package: "--package @=DIR"
  std::string held_joints;
  std::string xacro_arguments;
  std::string default_velocity;
  std::string allow_bare_links;
};

struct UrdfOptions {
  std::string base_link;                      ///< joints above it are held; empty: the root
  std::string tool_link;                      ///< empty: the SRDF's, else the last link of the longest chain
  Pose X_LT = Pose::Identity();               ///< tool frame in the tool link's frame
  std::vector<std::string> other_arms;        ///< tool links of the robot's other arms; their links are left out
  std::map<std::string, double> held_joints;  ///< positions of joints outside the chain [rad | m]; others are at 0
  std::map<std::string, MotionRange> moving_joints;  ///< outside the chain; others stay where they are held
  bool joints_of_all_arms = false;  ///< both have joints of the robot's other arms on purpose: no note says so
  std::string srdf_path;            ///< empty: no SRDF
  std::map<std::string, std::string> packages;  ///< package:// name → folder, searched first: resolve_resource()
  std::map<std::string, std::string> xacro_arguments;
  MeshGeometry meshes = MeshGeometry::kConvexHull;
  /// For all joints, because URDF has none [rad/s² | m/s²]; empty: assumed_acceleration().
  std::optional<double> default_acceleration = 10.0;
  std::optional<double> default_velocity;  ///< for joints without a limit above 0; empty: these are an error
  SourceFiles* sources = nullptr;          ///< opens the files; null: in place
  bool allow_bare_links = false;           ///< accepts moving bodies without collision geometry
  UrdfOptionNames names;
};

/// Loads the arm and applies its SRDF. Self pairs are not filtered yet: automatic_filter(). Throws ModelError.
[[nodiscard]] std::shared_ptr<const RobotModel> load_urdf(const std::string& urdf_path,
                                                          const UrdfOptions& options = {});

/// The type of a joint as URDF names it: "revolute".
[[nodiscard]] const char* urdf_type(JointType type);

}  // namespace hecaton::planner
