/// hecaton agent: becomes the agent of one host of a deployment.

#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "services/cli/child_agent.hpp"
#include "services/cli/commands.hpp"
#include "services/command_line/choice_option.hpp"
#include "services/command_line/failure.hpp"

namespace hecaton::services::cli {
namespace {

struct Options {
  std::string cell;
  std::optional<std::string> host;
  std::string log_dir;
  std::string log_level;
  bool no_restart = false;
  bool anew = false;
};

std::vector<std::string> arguments_for(const Settings& settings, const Options& options) {
  std::vector<std::string> words{options.cell};
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {name, value});
  };
  if (options.host) words.insert(words.end(), {"--host", *options.host});  // also an empty one, which is refused
  add("--log-dir", options.log_dir);
  add("--log-level", options.log_level);
  if (settings.domain) add("--domain", std::to_string(*settings.domain));
  if (options.no_restart) words.emplace_back("--no-restart");
  if (options.anew) words.emplace_back("--anew");
  return words;
}

/// Returns only to throw.
ExitCode become_agent(const Settings& settings, const Options& options) {
  std::string program = sibling_program("hecaton-agent");
  std::vector<std::string> words = arguments_for(settings, options);
  words.insert(words.begin(), program);
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  throw Failure(ExitCode::kBadInput, "program '" + program + "' cannot be run: " + std::strerror(errno));
}

}  // namespace

void add_agent(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("agent", "Starts, watches and restarts the services that a cell file places on a host");
  auto options = std::make_shared<Options>();
  command->add_option("CELL", options->cell, "cell file (YAML)")->required();
  command->add_option("--host", options->host, "the cell's host that this is; otherwise all of them")
      ->type_name("NAME");
  command->add_option("--log-dir", options->log_dir, "folder for each service's log; otherwise stderr")
      ->type_name("DIR");
  add_choice(*command, "--log-level", options->log_level, {"debug", "info", "warning", "error"},
             "least severity that is logged (info)");
  command->add_flag("--no-restart", options->no_restart, "leave services that die dead");
  command->add_flag("--anew", options->anew,
                    "forget what an agent that was killed has left, and its services remembered");
  command->callback([&session, options] {
    session.action = [&session, options] { return become_agent(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
