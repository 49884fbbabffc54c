#pragma once
/// The options with which commands load a URDF that no cell file describes.

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
  bool allow_bare_links = false;
  std::optional<double> default_velocity;  ///< [rad/s | m/s]
};

/// Parsing throws Failure (bad input) for a value that cannot be, such as an empty one.
void add_robot_options(CLI::App& app, RobotOptions& options);
/// Throws Failure (bad input) for a --package that is no NAME=DIR.
void check_robot_options(const RobotOptions& options);
/// Throws Failure (usage) when one of them was given for a cell file.
void refuse_robot_options(const CLI::App& command);

/// By the file's ending where that tells, otherwise by what is in it: a robot description is XML, and a cell file never
/// begins with '<'. Throws Failure (bad input) when it cannot be read.
[[nodiscard]] bool is_robot(const std::string& path);
/// Throws planner::ModelError.
[[nodiscard]] std::shared_ptr<const planner::RobotModel> load_robot(const std::string& path,
                                                                    const RobotOptions& options);

}  // namespace hecaton::services::cli
