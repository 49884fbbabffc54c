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
#include "services/command_line/terminal.hpp"
#include "services/config/robot_catalogue.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kAllowBareLinks = "--allow-bare-links";
constexpr const char* kDefaultVelocity = "--default-velocity";
constexpr const char* kJoint = "--joint";
constexpr const char* kXacro = "--xacro";
constexpr const char* kPackage = "--package";

/// "NAME=VALUE" as both parts. `option` and `form` are for the message.
std::pair<std::string, std::string> parts_of(const std::string& option, const std::string& entry,
                                             const std::string& form = "NAME=VALUE") {
  const std::size_t equals = entry.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size()) {
    throw Failure(ExitCode::kBadInput, option + " = '" + config::printable(entry) + "' must be " + form);
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

void add_robot_file_options(CLI::App& app, RobotFileOptions& options, const std::string& prefix) {
  const auto add = [&app, &prefix](const char* name, std::map<std::string, std::string>& values, const char* form,
                                   const char* description) {
    const auto read = [&values, name, form](const std::vector<std::string>& entries) {
      for (const std::string& entry : entries) values.insert(parts_of(name, entry, form));
    };
    app.add_option_function<std::vector<std::string>>(name, read, prefix + description)
        ->expected(1)
        ->take_all()
        ->type_name(form);
  };
  add(kXacro, options.xacro_arguments, "NAME=VALUE", "argument of a xacro file, NAME=VALUE");
  add(kPackage, options.packages, "NAME=DIR", "folder of a package:// name, NAME=DIR");
}

std::string words_of(const RobotFileOptions& options) {
  std::string words;
  for (const auto& [name, folder] : options.packages)
    words.append(" --package ").append(shell_word(name + "=" + folder));
  for (const auto& [name, value] : options.xacro_arguments) {
    words.append(" --xacro ").append(shell_word(name + "=" + value));
  }
  return words;
}

void name_file_options(planner::UrdfOptions& options) {
  options.names.packages = std::string(kPackage) + " @=DIR";
  options.names.xacro_arguments = std::string(kXacro) + " NAME=VALUE";
}

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
  add_robot_file_options(app, options.files, "URDF only: ");
  add_choice(app, "--meshes", options.meshes, {"hull", "capsule"},
             "URDF only: replace meshes by a convex hull or a capsule (hull)");
  app.add_flag(kAllowBareLinks, options.allow_bare_links, "URDF only: accept links without collision geometry");
  constexpr config::Bounds kVelocity{0.0, 1e3, "rad/s (m/s for a prismatic joint)", true};
  add_number(
      app, kDefaultVelocity, [&options](double velocity) { options.default_velocity = velocity; },
      "URDF only: velocity limit of joints without one [rad/s | m/s] (none: an error)", kVelocity);
}

void refuse_robot_options(const CLI::App& command) {
  for (const char* name :
       {"--srdf", "--tool", "--base", kJoint, kXacro, "--meshes", kPackage, kAllowBareLinks, kDefaultVelocity}) {
    if (command.count(name) == 0) continue;
    throw Failure(ExitCode::kUsage, std::string(name).append(" is for a URDF; in a cell file it is a key of the arm"));
  }
}

bool is_robot(const std::string& word) {
  if (config::means_robot(word)) return true;
  std::ifstream file(word);
  if (!file) {
    throw Failure(ExitCode::kBadInput, "'" + config::printable_path(word) +
                                           "' is no file that can be read, and no robot; " +
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
  urdf.xacro_arguments = options.files.xacro_arguments;
  urdf.packages = options.files.packages;
  urdf.meshes = options.meshes == "capsule" ? planner::MeshGeometry::kCapsule : planner::MeshGeometry::kConvexHull;
  urdf.allow_bare_links = options.allow_bare_links;
  urdf.default_acceleration.reset();
  urdf.default_velocity = options.default_velocity;
  name_file_options(urdf);
  const std::string file = shell_word(config::printable(word));
  urdf.names.tool_link = "--tool LINK; for both arms: hecaton init left=" + file + ":@first right=" + file +
                         ":@second" + words_of(options.files);
  urdf.names.held_joints = std::string(kJoint) + " NAME=VALUE";
  urdf.names.default_velocity = kDefaultVelocity;
  urdf.names.allow_bare_links = kAllowBareLinks;
  if (!config::means_robot(word)) return planner::load_arm_model(word, urdf);
  planner::SourceFiles sources;
  return config::load_named_robot(config::read_named_robot(word, sources), urdf);
}

}  // namespace hecaton::services::cli
