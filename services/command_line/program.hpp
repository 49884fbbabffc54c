#pragma once
/// A program that consists of commands: what all commands share, from the command line to the exit code.

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "services/runtime/options.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hecaton::services::cli {

enum class OutputFormat { kTable, kJson, kYaml };

/// Options that every command has.
struct Settings {
  std::string output = "table";  ///< --output: table, json or yaml
  std::optional<int> domain;     ///< --domain; empty: HECATON_DOMAIN, or the cell file's
  std::string cell_file;         ///< --cell or HECATON_CELL, for its network settings; empty: none
  double connect_timeout = 2.0;  ///< time limit for the answer of a cell [s]

  [[nodiscard]] OutputFormat format() const {
    return output == "json" ? OutputFormat::kJson : output == "yaml" ? OutputFormat::kYaml : OutputFormat::kTable;
  }
};

/// State of the command line between parsing and running.
struct Session {
  Settings settings;
  std::function<ExitCode()> action;  ///< of the command that was given; runs after all options are parsed
};

/// Ends a command with an exit code. what() is one sentence for people; empty when another process prints the sentence.
class Failure : public std::runtime_error {
 public:
  Failure(ExitCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

struct Program {
  std::string name;         ///< of the executable
  std::string summary;      ///< a phrase, for the man page
  std::string description;  ///< a sentence, for --help
  std::string exit_codes;   ///< their meanings, for --help
  /// Adds options and commands. The callback of each command sets `session.action`.
  std::function<void(CLI::App&, Session&)> add_commands;
};

/// The command line of `program`: option -o, the program's options and commands, and the commands `completion` and
/// `man`. `program` and `session` must outlive the result.
[[nodiscard]] std::unique_ptr<CLI::App> make_application(const Program& program, Session& session);

/// Parses the command line and runs the command. Prints failures on stderr as one sentence. Throws nothing.
[[nodiscard]] ExitCode run_program(const Program& program, int argc, const char* const* argv);

/// Options of a command and of its option groups, without --help; positionals first.
[[nodiscard]] std::vector<const CLI::Option*> options_of(const CLI::App& app);
[[nodiscard]] std::vector<const CLI::App*> subcommands_of(const CLI::App& app);

/// A man page in the language of man(7), made from the tables of CLI11 as --help is. `summary` follows the program's
/// name in section NAME.
[[nodiscard]] std::string man_page(const CLI::App& app, const std::string& summary, const std::string& version);

/// A completion script for bash, made from the same tables. A positional ARM completes to the arms of the running
/// cell, CELL and FILE complete to files.
[[nodiscard]] std::string bash_completion(const CLI::App& app);

}  // namespace hecaton::services::cli
