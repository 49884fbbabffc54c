#include "services/command_line/program.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "services/command_line/options.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

/// The innermost command that was recognised; sets `path` to its words ("hecaton obstacle add").
const CLI::App& given_command(const CLI::App& app, std::string& path) {
  const CLI::App* command = &app;
  path = app.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    path += " " + command->get_name();
  }
  return *command;
}

/// "no command 'sttus'; did you mean 'status'?" for a word that is no command or no option, where CLI11 suggests
/// nothing. Empty when the error is another one.
std::string unknown_word(const CLI::App& app, const CLI::App& command) {
  std::vector<std::string> words = command.remaining(true);
  if (words.empty()) words = app.remaining(true);
  if (words.empty()) return {};
  const std::string& word = words.front();
  const bool option = word.starts_with("-");
  std::vector<std::string> names;
  if (option) {
    const auto add = [&](const CLI::App& level) {
      for (const CLI::Option* known : options_of(level)) {
        if (!known->get_positional()) names.push_back("--" + known->get_lnames().front());
      }
    };
    add(command);
    if (&command != &app) add(app);
  } else {
    for (const CLI::App* known : subcommands_of(command)) names.push_back(known->get_name());
  }
  if (names.empty()) return {};
  const std::vector<std::string_view> known(names.begin(), names.end());
  return (option ? "no option '" : "no command '") + config::printable(word) + "'; " + config::suggestion(word, known);
}

/// CLI11 takes "-inf" among numbers for an option, but it is a bad value. Empty when there is none.
std::string number_like_an_option(const CLI::App& app) {
  const std::vector<std::string> words = app.remaining(true);
  const auto found = std::find_if(words.begin(), words.end(),
                                  [](const std::string& word) { return config::parse_number(word).has_value(); });
  if (found == words.end()) return {};
  return "'" + config::printable(*found) + "' must be a finite number";
}

/// A usage error as one sentence.
std::string usage_sentence(const CLI::App& app, const CLI::ParseError& error) {
  std::string path;
  const CLI::App& command = given_command(app, path);
  std::string sentence = unknown_word(app, command);
  if (sentence.empty()) sentence = error.what();
  std::replace(sentence.begin(), sentence.end(), '\n', ' ');
  return sentence + (sentence.ends_with('?') ? " See '" : "; see '") + path + " --help'";
}

void add_completion(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("completion", "Prints a script that completes commands in a shell");
  auto shell = std::make_shared<std::string>();
  command->add_option("SHELL", *shell, "bash")->required()->check(CLI::IsMember({"bash"}).description(""));
  command->footer("Try it: source <(" + app.get_name() + " completion bash)");
  // The callback owns `shell`, to which the option writes.
  command->callback([&app, &session, shell] {
    session.action = [&app] {
      std::fputs(bash_completion(app).c_str(), stdout);
      return ExitCode::kDone;
    };
  });
}

void add_man(CLI::App& app, Session& session, const std::string& summary) {
  CLI::App* command = app.add_subcommand("man", "Prints this program's man page");
  command->footer("Read it: " + app.get_name() + " man | man -l -");
  command->callback([&app, &session, summary] {
    session.action = [&app, summary] {
      std::fputs(man_page(app, summary, HECATON_VERSION).c_str(), stdout);
      return ExitCode::kDone;
    };
  });
}

}  // namespace

std::unique_ptr<CLI::App> make_application(const Program& program, Session& session) {
  auto app = std::make_unique<CLI::App>(program.description, program.name);
  app->set_version_flag("--version", program.name + " " + HECATON_VERSION);
  app->require_subcommand(1);
  app->fallthrough();
  app->get_formatter()->column_width(34);
  add_choice(*app, "-o,--output", session.settings.output, {"table", "json", "yaml"}, "how data is printed (table)");
  program.add_commands(*app, session);
  add_completion(*app, session);
  add_man(*app, session, program.summary);
  app->footer(program.exit_codes);  // last: commands that are added later would inherit it
  return app;
}

ExitCode run_program(const Program& program, int argc, const char* const* argv) {
  Session session;
  const auto app = make_application(program, session);
  const auto complain = [&](ExitCode code, const std::string& sentence) {
    if (!sentence.empty()) {
      std::fprintf(stderr, "%s: %s\n", program.name.c_str(), config::sentence_text(sentence).c_str());
    }
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
  } catch (const std::exception& error) {
    return complain(ExitCode::kBadInput, error.what());
  }
}

}  // namespace hecaton::services::cli
