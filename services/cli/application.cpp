#include "services/cli/application.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "services/cli/choice_option.hpp"
#include "services/cli/command_line_shape.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done; 1 it ran and the outcome is negative (goal blocked or rejected, contacts seen, tasks missed); "
    "2 usage; 3 bad input (cell, URDF, arm, object); 4 time-out; 5 no such cell reachable.";

void add_global_options(CLI::App& app, Settings& settings) {
  add_choice(app, "-o,--output", settings.output, {"table", "json", "yaml"}, "how data is printed (table)");
  app.add_option("--domain", settings.domain,
                 "DDS domain, 0 to 199; otherwise HECATON_DOMAIN, otherwise the cell file's, otherwise 42")
      ->check(CLI::Range(0, 199).description(""))
      ->type_name("N");
  app.add_option("--cell", settings.cell_file, "cell file whose network settings are used to reach the cell")
      ->envname("HECATON_CELL")
      ->type_name("FILE");
  add_duration(app, "--connect-timeout", settings.connect_timeout, "how long to look for a running cell (2s)", 0.01,
               600.0);
}

/// CLI11 says of an unknown command only that one is required.
std::string unknown_command(const CLI::App& app, int argc, const char* const* argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word.starts_with("-")) return {};
    std::vector<std::string_view> names;
    for (const CLI::App* command : subcommands_of(app)) names.push_back(command->get_name());
    if (std::find(names.begin(), names.end(), word) != names.end()) return {};
    return "no command '" + config::printable(word) + "'; did you mean '" +
           std::string(config::nearest_word(word, names)) + "'?";
  }
  return {};
}

}  // namespace

std::unique_ptr<CLI::App> make_application(Session& session) {
  auto app = std::make_unique<CLI::App>(
      "Drives cells of robot arms that plan their motions together: one planner process for each arm, on DDS.",
      "hecaton");
  app->set_version_flag("--version", std::string("hecaton ") + HECATON_VERSION);
  app->require_subcommand(1);
  app->fallthrough();
  app->get_formatter()->column_width(34);
  add_global_options(*app, session.settings);
  add_up(*app, session);
  add_agent(*app, session);
  add_status(*app, session);
  add_arms(*app, session);
  add_faults(*app, session);
  add_obstacles(*app, session);
  add_hosts(*app, session);
  add_goal(*app, session);
  add_wait(*app, session);
  add_mode_commands(*app, session);
  add_obstacle(*app, session);
  add_carry_commands(*app, session);
  add_check(*app, session);
  add_simulate(*app, session);
  add_completion(*app, session);
  add_man(*app, session);
  app->footer(kExitCodes);  // last, because commands would inherit it
  return app;
}

ExitCode run_application(int argc, const char* const* argv) {
  Session session;
  const auto app = make_application(session);
  try {
    app->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (const std::string unknown = unknown_command(*app, argc, argv); !unknown.empty()) {
      std::fprintf(stderr, "hecaton: %s\n", unknown.c_str());
      return ExitCode::kUsage;
    }
    return app->exit(error) == 0 ? ExitCode::kDone : ExitCode::kUsage;
  }
  ExitCode code = ExitCode::kDone;
  const auto complain = [&](ExitCode because, const std::exception& error) {
    std::fprintf(stderr, "hecaton: %s\n", error.what());
    code = because;
  };
  try {
    code = session.action();
  } catch (const Failure& failure) {
    complain(failure.code(), failure);
  } catch (const std::exception& error) {
    complain(ExitCode::kBadInput, error);
  }
  return code;
}

}  // namespace hecaton::services::cli
