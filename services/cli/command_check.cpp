/// hecaton check: validates a cell file or a URDF and explains what the planners will make of it.

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "planner/collision/model_filter.hpp"
#include "services/cli/choice_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/describe_model.hpp"
#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"
#include "services/runtime/join.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kAllowBareLinks = "--allow-bare-links";
constexpr const char* kDefaultVelocity = "--default-velocity";

struct Options {
  std::string file;
  std::string srdf;
  std::string tool;
  std::string meshes = "hull";
  std::vector<std::string> packages;
  bool allow_bare_links = false;
  std::optional<double> default_velocity;  // [rad/s | m/s]
};

/// By the file's ending where that tells, otherwise by what is in it: a robot description is XML, and a cell file never
/// begins with '<'.
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

ExitCode check_urdf(const Settings& settings, const Options& options) {
  planner::UrdfOptions urdf;
  urdf.srdf_path = options.srdf;
  urdf.tool_link = options.tool;
  urdf.packages = packages_of(options.packages);
  urdf.meshes = options.meshes == "capsule" ? planner::MeshGeometry::kCapsule : planner::MeshGeometry::kConvexHull;
  urdf.allow_bare_links = options.allow_bare_links;
  urdf.name_of_allow_bare_links = kAllowBareLinks;
  urdf.default_velocity = options.default_velocity;
  urdf.name_of_default_velocity = kDefaultVelocity;
  const auto model = planner::load_arm_model(options.file, urdf);
  print(settings, model_json(*model, model->limits), model_text(*model, model->limits, Palette::for_stream(stdout)));
  return ExitCode::kDone;
}

ExitCode check_cell(const Settings& settings, const Options& options) {
  const config::CellFile file = config::load_cell_file(options.file);
  require_interface(file);
  const Findings findings = config::validate(file);
  print(settings, cell_json(file, findings), cell_text(file, findings, Palette::for_stream(stdout)));
  const bool works = findings.empty() || findings.front().severity != config::Severity::kError;  // errors come first
  return works ? ExitCode::kDone : ExitCode::kNegative;
}

/// Throws Failure (usage) when an option that only a URDF has was given for a cell file.
void refuse_robot_options(const CLI::App& command) {
  for (const char* name : {"--srdf", "--tool", "--meshes", "--package", kAllowBareLinks, kDefaultVelocity}) {
    if (command.count(name) == 0) continue;
    throw Failure(ExitCode::kUsage, std::string(name).append(" is for a URDF alone: a cell file says it of each arm"));
  }
}

}  // namespace

void add_check(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("check", "Validates a cell file or a URDF and explains it, without starting anything");
  auto options = std::make_shared<Options>();
  command->add_option("FILE", options->file, "cell file (YAML) or robot description (URDF)")->required();
  command->add_option("--srdf", options->srdf, "URDF only: SRDF with its collision filter and poses")
      ->type_name("FILE");
  command->add_option("--tool", options->tool, "URDF only: link of the tool frame; otherwise the chain's last")
      ->type_name("LINK");
  add_choice(*command, "--meshes", options->meshes, {"hull", "capsule"},
             "URDF only: meshes become a convex hull or a capsule (hull)");
  command->add_option("--package", options->packages, "URDF only: folder of a package:// name, NAME=DIR")
      ->expected(1)
      ->take_all()
      ->type_name("NAME=DIR");
  command->add_flag(kAllowBareLinks, options->allow_bare_links, "URDF only: accept links without collision geometry");
  constexpr config::Bounds kVelocity{0.0, 1e3, "rad/s (m/s for a prismatic joint)", true};
  add_number(
      *command, kDefaultVelocity, [options = options.get()](double velocity) { options->default_velocity = velocity; },
      "URDF only: velocity limit of joints that have none [rad/s | m/s]; otherwise they are refused", kVelocity);
  command->callback([&session, options, command] {
    static_cast<void>(packages_of(options->packages));
    session.action = [&session, options, command] {
      if (is_robot(options->file)) return check_urdf(session.settings, *options);
      refuse_robot_options(*command);
      return check_cell(session.settings, *options);
    };
  });
}

}  // namespace hecaton::services::cli
