#include "services/cli/robot_options.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>

#include <CLI/CLI.hpp>

#include "planner/collision/model_filter.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/config/robot_catalogue.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kAllowBareLinks = "--allow-bare-links";
constexpr const char* kDefaultVelocity = "--default-velocity";
constexpr const char* kJoint = "--joint";
constexpr const char* kXacro = "--xacro";

[[noreturn]] void refuse_package(const std::string& entry) {
  throw Failure(ExitCode::kBadInput, "--package = '" + config::printable(entry) + "' must be NAME=DIR");
}

std::map<std::string, std::string> packages_of(const std::vector<std::string>& entries) {
  std::map<std::string, std::string> packages;
  for (const std::string& entry : entries) {
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size()) {
      refuse_package(entry);
    }
    packages[entry.substr(0, equals)] = entry.substr(equals + 1);
  }
  return packages;
}

/// "NAME=VALUE" as both parts. `option` is for the message.
std::pair<std::string, std::string> parts_of(const std::string& option, const std::string& entry) {
  const std::size_t equals = entry.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size()) {
    throw Failure(ExitCode::kBadInput, option + " = '" + config::printable(entry) + "' must be NAME=VALUE");
  }
  return {entry.substr(0, equals), entry.substr(equals + 1)};
}

/// An option whose text must not be empty: a script with an unset variable must not plan without its file.
void add_given_text(CLI::App& app, const std::string& name, std::string& text, const std::string& must_be,
                    const std::string& description, const std::string& type) {
  const auto set = [name, &text, must_be](const std::string& given) {
    if (given.empty()) throw Failure(ExitCode::kBadInput, name + " = '' must be " + must_be);
    text = given;
  };
  app.add_option_function<std::string>(name, set, description)->type_name(type);
}

}  // namespace

void add_robot_options(CLI::App& app, RobotOptions& options) {
  add_given_text(app, "--srdf", options.srdf, "the path of an SRDF",
                 "URDF only: SRDF with collision filter and named poses", "FILE");
  add_given_text(app, "--tool", options.tool, "the name of a link",
                 "URDF only: link of the tool frame (the SRDF's, else the last link of the longest chain)", "LINK");
  add_given_text(app, "--base", options.base, "the name of a link",
                 "URDF only: joints above this link are held (the root link)", "LINK");
  const auto add_joint = [&options](const std::vector<std::string>& entries) {
    for (const std::string& entry : entries) {
      const auto [name, text] = parts_of(kJoint, entry);
      const auto position = config::parse_number(text);
      if (!position || !std::isfinite(*position)) {
        throw Failure(ExitCode::kBadInput, std::string(kJoint) + " = '" + config::printable(entry) +
                                               "' must be NAME=VALUE with a number, in rad or m");
      }
      options.held_joints[name] = *position;
    }
  };
  app.add_option_function<std::vector<std::string>>(
         kJoint, add_joint, "URDF only: position of a joint outside the chain, NAME=VALUE [rad | m] (0)")
      ->expected(1)
      ->take_all()
      ->type_name("NAME=VALUE");
  const auto add_argument = [&options](const std::vector<std::string>& entries) {
    for (const std::string& entry : entries) options.xacro_arguments.insert(parts_of(kXacro, entry));
  };
  app.add_option_function<std::vector<std::string>>(kXacro, add_argument,
                                                    "URDF only: argument of a xacro file, NAME=VALUE")
      ->expected(1)
      ->take_all()
      ->type_name("NAME=VALUE");
  add_choice(app, "--meshes", options.meshes, {"hull", "capsule"},
             "URDF only: replace meshes by a convex hull or a capsule (hull)");
  app.add_option("--package", options.packages, "URDF only: folder of a package:// name, NAME=DIR")
      ->expected(1)
      ->take_all()
      ->type_name("NAME=DIR");
  app.add_flag(kAllowBareLinks, options.allow_bare_links, "URDF only: accept links without collision geometry");
  constexpr config::Bounds kVelocity{0.0, 1e3, "rad/s (m/s for a prismatic joint)", true};
  add_number(
      app, kDefaultVelocity, [&options](double velocity) { options.default_velocity = velocity; },
      "URDF only: velocity limit of joints without one [rad/s | m/s] (none: an error)", kVelocity);
}

void check_robot_options(const RobotOptions& options) {
  static_cast<void>(packages_of(options.packages));
}

void refuse_robot_options(const CLI::App& command) {
  for (const char* name :
       {"--srdf", "--tool", "--base", kJoint, kXacro, "--meshes", "--package", kAllowBareLinks, kDefaultVelocity}) {
    if (command.count(name) == 0) continue;
    throw Failure(ExitCode::kUsage, std::string(name).append(" is for a URDF; in a cell file it is a key of the arm"));
  }
}

bool is_robot(const std::string& word) {
  std::ifstream file(word);
  if (!file && config::is_robot_name(word)) return true;
  if (!file) {
    throw Failure(ExitCode::kBadInput, "'" + config::printable(word) + "' is no file that can be read, and no robot; " +
                                           config::robot_suggestion(word));
  }
  const std::string ending = std::filesystem::path(word).extension();
  if (ending == ".urdf" || ending == ".xml") return true;
  if (ending == ".yaml" || ending == ".yml") return false;
  char c = ' ';
  while (file.get(c)) {
    if (c == '<') return true;
    if (c != ' ' && c != '\n' && c != '\r' && c != '\t' && c != '\xEF' && c != '\xBB' && c != '\xBF') return false;
  }
  return false;
}

std::shared_ptr<const planner::RobotModel> load_robot(const std::string& word, const RobotOptions& options) {
  planner::UrdfOptions urdf;
  urdf.srdf_path = options.srdf;
  urdf.tool_link = options.tool;
  urdf.base_link = options.base;
  urdf.held_joints = options.held_joints;
  urdf.xacro_arguments = options.xacro_arguments;
  urdf.packages = packages_of(options.packages);
  urdf.meshes = options.meshes == "capsule" ? planner::MeshGeometry::kCapsule : planner::MeshGeometry::kConvexHull;
  urdf.allow_bare_links = options.allow_bare_links;
  urdf.default_acceleration.reset();
  urdf.default_velocity = options.default_velocity;
  urdf.names = {
      "--tool LINK",    "--package @=DIR", std::string(kJoint) + " NAME=VALUE", std::string(kXacro) + " NAME=VALUE",
      kDefaultVelocity, kAllowBareLinks};
  if (std::filesystem::exists(word)) return planner::load_arm_model(word, urdf);
  planner::SourceFiles sources;
  return config::load_named_robot(config::read_named_robot(word, sources), urdf);
}

}  // namespace hecaton::services::cli
