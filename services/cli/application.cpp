#include "services/cli/application.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/choice_option.hpp"
#include "services/cli/command_line_shape.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/config/text.hpp"
#include "services/runtime/options.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done; 1 it ran and the outcome is negative (goal blocked or rejected, contacts seen, tasks missed); "
    "2 usage: no such command, option or choice, or one too many or too few; 3 bad input: a value that cannot be, on "
    "the "
    "command line, in a file or in the environment (number, name, cell, URDF, arm, object); 4 time-out; 5 no such cell "
    "reachable.";

void add_global_options(CLI::App& app, Settings& settings) {
  add_choice(app, "-o,--output", settings.output, {"table", "json", "yaml"}, "how data is printed (table)");
  add_whole_number(
      app, "--domain", [&settings](std::uint64_t domain) { settings.domain = static_cast<int>(domain); },
      "DDS domain, 0 to 199; otherwise HECATON_DOMAIN, otherwise the cell file's, otherwise 42", 0, kHighestDomain);
  app.add_option("--cell", settings.cell_file, "cell file whose network settings are used to reach the cell")
      ->envname("HECATON_CELL")
      ->type_name("FILE");
  add_duration(app, "--connect-timeout", settings.connect_timeout, "how long to look for a running cell (2s)", 0.01,
               600.0);
}

/// The command that was named, as far as it is known: "obstacle add".
const CLI::App& given_command(const CLI::App& app, std::string& path) {
  const CLI::App* command = &app;
  path = app.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    path += " " + command->get_name();
  }
  return *command;
}

/// "no command 'sttus'; did you mean 'status'?", for a word that is no command or no option; CLI11 itself says only
/// that it did not expect it, or that a command is required. Empty when that is not what is wrong.
std::string unknown_word(const CLI::App& app, const CLI::App& command) {
  std::vector<std::string> words = command.remaining(true);
  if (words.empty()) words = app.remaining(true);
  if (words.empty()) return {};
  const std::string& word = words.front();
  const bool option = word.starts_with("-");
  std::vector<std::string> names;
  if (option) {
    for (const CLI::App* level : {&command, &app}) {
      for (const CLI::Option* known : options_of(*level)) {
        if (!known->get_positional()) names.push_back("--" + known->get_lnames().front());
      }
    }
  } else {
    for (const CLI::App* known : subcommands_of(command)) names.push_back(known->get_name());
  }
  if (names.empty()) return {};
  const std::vector<std::string_view> known(names.begin(), names.end());
  return (option ? "no option '" : "no command '") + config::printable(word) + "'; " + config::suggestion(word, known);
}

/// "-inf" among numbers looks like an option; it is a bad value. Empty when there is none.
std::string number_like_an_option(const CLI::App& app) {
  const std::vector<std::string> words = app.remaining(true);
  const auto found = std::find_if(words.begin(), words.end(),
                                  [](const std::string& word) { return config::parse_number(word).has_value(); });
  if (found == words.end()) return {};
  return "'" + config::printable(*found) + "' must be a finite number";
}

/// One sentence about wrong usage.
std::string usage_sentence(const CLI::App& app, const CLI::ParseError& error) {
  std::string path;
  const CLI::App& command = given_command(app, path);
  std::string sentence = unknown_word(app, command);
  if (sentence.empty()) sentence = error.what();
  std::replace(sentence.begin(), sentence.end(), '\n', ' ');
  return sentence + (sentence.ends_with('?') ? " See '" : "; see '") + path + " --help'";
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
  add_plan(*app, session);
  add_simulate(*app, session);
  add_strategies(*app, session);
  add_completion(*app, session);
  add_man(*app, session);
  app->footer(kExitCodes);  // last, because commands would inherit it
  return app;
}

ExitCode run_application(int argc, const char* const* argv) {
  Session session;
  const auto app = make_application(session);
  const auto complain = [](ExitCode code, const std::string& sentence) {
    if (!sentence.empty()) std::fprintf(stderr, "hecaton: %s\n", sentence.c_str());
    return code;
  };
  try {
    app->parse(argc, argv);
    const ExitCode code = session.action();
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
    return complain(ExitCode::kNegative, std::string("the output cannot be written: ") + std::strerror(errno));
  } catch (const CLI::Success& help) {
    app->exit(help);
    return ExitCode::kDone;
  } catch (const CLI::ParseError& error) {
    if (const std::string bad = number_like_an_option(*app); !bad.empty()) return complain(ExitCode::kBadInput, bad);
    return complain(ExitCode::kUsage, usage_sentence(*app, error));
  } catch (const Failure& failure) {
    return complain(failure.code(), failure.what());
  } catch (const Error& error) {
    const Failure failure = failure_of(error);
    return complain(failure.code(), failure.what());
  } catch (const std::exception& error) {
    return complain(ExitCode::kBadInput, error.what());
  }
}

}  // namespace hecaton::services::cli
