#pragma once
/// Options of commands that load a URDF or a robot by name instead of a cell file.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planner/model/robot_model.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace hecaton::services::cli {

struct RobotOptions {
  std::string srdf;
  std::string tool;
  std::string meshes = "hull";
  std::vector<std::string> packages;
  std::string base;
  std::map<std::string, double> held_joints;  ///< [rad | m]
  std::map<std::string, std::string> xacro_arguments;
  bool allow_bare_links = false;
  std::optional<double> default_velocity;  ///< [rad/s | m/s]
};

/// Adds the options. Parsing throws Failure (bad input) for an invalid value, such as an empty one.
void add_robot_options(CLI::App& app, RobotOptions& options);
/// Throws Failure (bad input) for a --package that is not NAME=DIR.
void check_robot_options(const RobotOptions& options);
/// For a cell file: throws Failure (usage) when one of the options was given.
void refuse_robot_options(const CLI::App& command);

/// True for a URDF and for the name of a robot, false for a cell file: by the extension if it is .urdf, .xml, .yaml or
/// .yml, otherwise by the content (XML begins with '<'). A file has precedence over the name of a robot. Throws Failure
/// (bad input) for anything else.
[[nodiscard]] bool is_robot(const std::string& word);
/// Loads the URDF or the named robot. Throws planner::ModelError.
[[nodiscard]] std::shared_ptr<const planner::RobotModel> load_robot(const std::string& word,
                                                                    const RobotOptions& options);

}  // namespace hecaton::services::cli
