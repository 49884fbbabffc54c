#include "services/cli/robot_options.hpp"

#include <filesystem>
#include <fstream>
#include <map>

#include <CLI/CLI.hpp>

#include "planner/collision/model_filter.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kAllowBareLinks = "--allow-bare-links";
constexpr const char* kDefaultVelocity = "--default-velocity";

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
                 "URDF only: link of the tool frame (last link of the chain)", "LINK");
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
      "URDF only: velocity limit of joints without one [rad/s | m/s] (none: such joints are rejected)", kVelocity);
}

void check_robot_options(const RobotOptions& options) {
  static_cast<void>(packages_of(options.packages));
}

void refuse_robot_options(const CLI::App& command) {
  for (const char* name : {"--srdf", "--tool", "--meshes", "--package", kAllowBareLinks, kDefaultVelocity}) {
    if (command.count(name) == 0) continue;
    throw Failure(ExitCode::kUsage, std::string(name).append(" is for a URDF; in a cell file it is a key of the arm"));
  }
}

bool is_robot(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be read");
  const std::string ending = std::filesystem::path(path).extension();
  if (ending == ".urdf" || ending == ".xml") return true;
  if (ending == ".yaml" || ending == ".yml") return false;
  char c = ' ';
  while (file.get(c)) {
    if (c == '<') return true;
    if (c != ' ' && c != '\n' && c != '\r' && c != '\t' && c != '\xEF' && c != '\xBB' && c != '\xBF') return false;
  }
  return false;
}

std::shared_ptr<const planner::RobotModel> load_robot(const std::string& path, const RobotOptions& options) {
  planner::UrdfOptions urdf;
  urdf.srdf_path = options.srdf;
  urdf.tool_link = options.tool;
  urdf.packages = packages_of(options.packages);
  urdf.meshes = options.meshes == "capsule" ? planner::MeshGeometry::kCapsule : planner::MeshGeometry::kConvexHull;
  urdf.allow_bare_links = options.allow_bare_links;
  urdf.name_of_allow_bare_links = kAllowBareLinks;
  urdf.default_acceleration.reset();
  urdf.default_velocity = options.default_velocity;
  urdf.name_of_default_velocity = kDefaultVelocity;
  return planner::load_arm_model(path, urdf);
}

}  // namespace hecaton::services::cli
