#pragma once
/// The command line described once more, from CLI11's own tables: the man page and the shell completion are made from
/// it, so that they never say anything else than --help.

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hecaton::services::cli {

/// Its options, also those of its option groups, without --help; positionals first.
[[nodiscard]] std::vector<const CLI::Option*> options_of(const CLI::App& app);
[[nodiscard]] std::vector<const CLI::App*> subcommands_of(const CLI::App& app);

/// A page in man(7)'s language; `summary` stands behind the program's name.
[[nodiscard]] std::string man_page(const CLI::App& app, const std::string& summary, const std::string& version);

/// A script that bash sources. A positional ARM is completed by the arms of the running cell, CELL and FILE by files.
[[nodiscard]] std::string bash_completion(const CLI::App& app);

}  // namespace hecaton::services::cli
