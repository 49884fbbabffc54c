/// hecaton agent: runs the agent of one host of a deployment in place of this process.

#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "services/cli/commands.hpp"
#include "services/cli/running_cell.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"

namespace hecaton::services::cli {
namespace {

struct AgentOptions {
  std::string cell;
  std::optional<std::string> host;
  std::string log_dir;
  std::string log_level;
  bool no_restart = false;
  bool clean = false;
  bool view = false;
};

std::vector<std::string> arguments_for(const Settings& settings, const AgentOptions& options) {
  std::vector<std::string> words{options.cell};
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {name, value});
  };
  if (options.host)
    words.insert(words.end(), {"--host", *options.host});  // an empty name is passed on, and the agent refuses it
  add("--log-dir", options.log_dir);
  add("--log-level", options.log_level);
  if (settings.domain) add("--domain", std::to_string(*settings.domain));
  if (options.no_restart) words.emplace_back("--no-restart");
  if (options.clean) words.emplace_back("--clean");
  if (options.view) words.emplace_back("--view");
  return words;
}

/// Does not return; throws Failure when the agent cannot be run.
ExitCode become_agent(const Settings& settings, const AgentOptions& options) {
  become("hecaton-agent", arguments_for(settings, options));
}

}  // namespace

void add_agent(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("agent", "Starts, watches and restarts the services that a cell file places on a host");
  auto options = std::make_shared<AgentOptions>();
  command->add_option("CELL", options->cell, "cell file (YAML)")->required();
  command->add_option("--host", options->host, "name of this host in the cell file (all hosts)")->type_name("NAME");
  command->add_option("--log-dir", options->log_dir, "folder for the logs of the services (stderr)")->type_name("DIR");
  add_choice(*command, "--log-level", options->log_level, {"debug", "info", "warning", "error"},
             "lowest severity that is logged (info)");
  command->add_flag("--no-restart", options->no_restart, "do not restart services that exit");
  command->add_flag("--clean", options->clean, "delete the checkpoints and records of an earlier run");
  command->add_flag("--view", options->view, "start the view on the first host also if the cell file has no key view");
  command->callback([&session, options] {
    session.action = [&session, options] { return become_agent(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
