/// hecaton check: validates a cell file or a URDF and explains what the planners will make of it.

#include <fstream>
#include <map>
#include <memory>

#include <CLI/CLI.hpp>

#include "planner/collision/model_filter.hpp"
#include "services/cli/choice_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/describe_model.hpp"
#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services::cli {
namespace {

struct Options {
  std::string file;
  std::string srdf;
  std::string tool;
  std::string meshes = "hull";
  std::vector<std::string> packages;
  bool allow_bare_links = false;
};

/// A robot description is XML; a cell file never begins with '<'.
bool is_xml(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be read");
  char c = ' ';
  while (file.get(c)) {
    if (c == '<') return true;
    if (c != ' ' && c != '\n' && c != '\r' && c != '\t' && c != '\xEF' && c != '\xBB' && c != '\xBF') return false;
  }
  return false;
}

std::map<std::string, std::string> packages_of(const std::vector<std::string>& entries) {
  std::map<std::string, std::string> packages;
  for (const std::string& entry : entries) {
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size()) {
      throw CLI::ValidationError("--package = '" + entry + "' must be NAME=DIR");
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
  const auto model = planner::load_arm_model(options.file, urdf);
  print(settings, model_json(*model, model->limits), model_text(*model, model->limits, Palette::for_stream(stdout)));
  return ExitCode::kDone;
}

ExitCode check_cell(const Settings& settings, const Options& options) {
  const config::CellFile file = config::load_cell_file(options.file);
  print(settings, cell_json(file), cell_text(file, Palette::for_stream(stdout)));
  return ExitCode::kDone;
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
  command->add_flag("--allow-bare-links", options->allow_bare_links,
                    "URDF only: accept links without collision geometry");
  command->callback([&session, options] {
    static_cast<void>(packages_of(options->packages));
    session.action = [&session, options] {
      return is_xml(options->file) ? check_urdf(session.settings, *options) : check_cell(session.settings, *options);
    };
  });
}

}  // namespace hecaton::services::cli
