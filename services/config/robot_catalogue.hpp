#pragma once
/// Robots by name: the folder deploy/robots of the sources, which the package installs. Each robot is a URDF and a YAML
/// file of the same name with title, reach, payload, poses, sources and what is approximate.

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"
#include "planner/model/urdf_loader.hpp"

namespace hecaton::config {

/// The end of an arm of a robot, and the poses of the chain to it.
struct RobotTool {
  std::string link;
  std::map<std::string, std::vector<double>> poses;  ///< from base to tip [rad | m]; always has `home`
};

/// A robot of the catalogue. The figures are those that its maker publishes.
struct NamedRobot {
  std::string name;
  std::string title;                 ///< maker and product
  std::string urdf;                  ///< path of the file
  double reach = 0.0;                ///< [m]
  double payload = 0.0;              ///< [kg]
  std::vector<RobotTool> tools;      ///< at least one, the first is the default; several: the robot has several arms
  std::vector<double> acceleration;  ///< of the joints to any tool [rad/s² | m/s²]
  std::vector<std::string> sources;
  std::vector<std::string> approximate;
};

/// The folder of the catalogue: HECATON_ROBOTS if it is set, else `share/hecaton/robots` in one of the five folders
/// above the program or shared library that has this code (build tree and installation), else that of the Debian
/// package.
[[nodiscard]] std::filesystem::path robots_folder();

/// All names in order; empty when there is no such folder.
[[nodiscard]] std::vector<std::string> robot_names();

/// True if `sources` has a robot of this name.
[[nodiscard]] bool is_robot_name(std::string_view name, const planner::SourceFiles& sources = planner::SourceFiles());

/// True if a word of the command line means a robot of the catalogue: no file has its name. A folder may, such as that
/// of the robot's meshes.
[[nodiscard]] bool means_robot(const std::string& word);

/// What to do about a name that is no robot: "did you mean 'ur5e'?", or all names.
[[nodiscard]] std::string robot_suggestion(std::string_view name);

/// Reads the entry of a robot. Throws ConfigError when there is none, or when it is malformed.
[[nodiscard]] NamedRobot read_named_robot(const std::string& name, planner::SourceFiles& sources);

/// The tools of the robot that a word of the command line names; empty: the word is a file, or no name.
[[nodiscard]] std::vector<RobotTool> tools_of(const std::string& word);

/// Loads the robot's URDF for planning. Options without a tool link get the robot's first tool. The model has the
/// catalogue's accelerations, its poses of the chosen chain, and a note about what is approximate. Throws ModelError.
[[nodiscard]] std::shared_ptr<const planner::RobotModel> load_named_robot(const NamedRobot& robot,
                                                                          planner::UrdfOptions options = {});

}  // namespace hecaton::config
