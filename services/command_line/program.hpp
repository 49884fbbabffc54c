#pragma once
/// A program that consists of commands: what they all share, from the command line to the exit code.

#include <functional>
#include <memory>
#include <string>

#include "services/command_line/settings.hpp"

namespace hecaton::services::cli {

struct Program {
  std::string name;         ///< of the executable
  std::string summary;      ///< half a sentence, for the man page
  std::string description;  ///< a sentence, for --help
  std::string exit_codes;   ///< what they mean
  /// Adds options and commands; each command leaves what it does in `session.action`.
  std::function<void(CLI::App&, Session&)> add_commands;
};

/// The command line: the option -o, what the program adds, and the commands `completion` and `man`. `program` and
/// `session` must outlive the result.
[[nodiscard]] std::unique_ptr<CLI::App> make_application(const Program& program, Session& session);

/// Parses, runs the command, and explains on stderr what went wrong.
[[nodiscard]] ExitCode run_program(const Program& program, int argc, const char* const* argv);

}  // namespace hecaton::services::cli
