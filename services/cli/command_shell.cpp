/// hecaton completion, hecaton man: what a package installs beside the program.

#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/command_line_shape.hpp"
#include "services/cli/commands.hpp"

namespace hecaton::services::cli {

void add_completion(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("completion", "Prints a script that completes commands in a shell");
  auto shell = std::make_shared<std::string>();
  command->add_option("SHELL", *shell, "bash")->required()->check(CLI::IsMember({"bash"}).description(""));
  command->footer("Try it: source <(hecaton completion bash)");
  // The callback keeps `shell` alive, which the option writes to.
  command->callback([&app, &session, shell] {
    session.action = [&app] {
      std::fputs(bash_completion(app).c_str(), stdout);
      return ExitCode::kDone;
    };
  });
}

void add_man(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("man", "Prints this program's man page");
  command->footer("Read it: hecaton man | man -l -");
  command->callback([&app, &session] {
    session.action = [&app] {
      std::fputs(man_page(app, HECATON_VERSION).c_str(), stdout);
      return ExitCode::kDone;
    };
  });
}

}  // namespace hecaton::services::cli
