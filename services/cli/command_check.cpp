/// hecaton check: validates a cell file or a URDF and explains what the planners will make of it.

#include <memory>

#include <CLI/CLI.hpp>

#include "services/arm_driver/device_choice.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/describe_model.hpp"
#include "services/cli/robot_options.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/join.hpp"

namespace hecaton::services::cli {
namespace {

struct Options {
  std::string file;
  RobotOptions robot;
};

ExitCode check_urdf(const Settings& settings, const Options& options) {
  const auto model = load_robot(options.file, options.robot);
  print(settings, model_json(*model, model->limits), model_text(*model, model->limits, Palette::for_stream(stdout)));
  return ExitCode::kDone;
}

ExitCode check_cell(const Settings& settings, const Options& options) {
  const config::CellFile file = config::load_cell_file(options.file);
  require_interface(file);
  require_known_devices(file);
  const Findings findings = config::validate(file);
  print(settings, cell_json(file, findings), cell_text(file, findings, Palette::for_stream(stdout)));
  const bool works = findings.empty() || findings.front().severity != config::Severity::kError;  // errors come first
  return works ? ExitCode::kDone : ExitCode::kNegative;
}

}  // namespace

void add_check(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("check", "Validates a cell file or a URDF and explains it, without starting anything");
  auto options = std::make_shared<Options>();
  command->add_option("FILE", options->file, "cell file (YAML) or robot description (URDF)")->required();
  add_robot_options(*command, options->robot);
  command->callback([&session, options, command] {
    check_robot_options(options->robot);
    session.action = [&session, options, command] {
      if (is_robot(options->file)) return check_urdf(session.settings, *options);
      refuse_robot_options(*command);
      return check_cell(session.settings, *options);
    };
  });
}

}  // namespace hecaton::services::cli
