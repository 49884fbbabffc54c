#pragma once
/// Options of commands that load a URDF or a robot by name instead of a cell file.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planner/model/robot_model.hpp"
#include "planner/model/urdf_loader.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace hecaton::services::cli {

/// What the files of a robot need beside their path.
struct RobotFileOptions {
  std::map<std::string, std::string> packages;         ///< folders by name
  std::map<std::string, std::string> xacro_arguments;  ///< values by name
};

/// Adds --package and --xacro. Parsing throws Failure (bad input) for an invalid value. `prefix`: of the descriptions.
void add_robot_file_options(CLI::App& app, RobotFileOptions& options, const std::string& prefix);
/// The options as a user writes them: " --package NAME=DIR --xacro NAME=VALUE".
[[nodiscard]] std::string words_of(const RobotFileOptions& options);
/// Names of these options, for messages.
void name_file_options(planner::UrdfOptions& options);

struct RobotOptions {
  std::string srdf;
  std::string tool;
  std::string meshes = "hull";
  RobotFileOptions files;
  std::string base;
  std::map<std::string, double> held_joints;  ///< [rad | m]
  bool allow_bare_links = false;
  std::optional<double> default_velocity;  ///< [rad/s | m/s]
};

/// Adds the options. Parsing throws Failure (bad input) for an invalid value, such as an empty one.
void add_robot_options(CLI::App& app, RobotOptions& options);
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
