#pragma once
/// What the command line says for every command, and what a command leaves to be run once all of it is parsed.

#include <functional>
#include <optional>
#include <string>

#include "services/runtime/exit_code.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace hecaton::services::cli {

enum class OutputFormat { kTable, kJson, kYaml };

struct Settings {
  std::string output = "table";  ///< --output: table, json or yaml
  std::optional<int> domain;     ///< --domain; otherwise HECATON_DOMAIN, otherwise the cell file's
  std::string cell_file;         ///< --cell or HECATON_CELL, for its network settings; empty: none
  double connect_timeout = 2.0;  ///< until a cell must have answered [s]

  [[nodiscard]] OutputFormat format() const {
    return output == "json" ? OutputFormat::kJson : output == "yaml" ? OutputFormat::kYaml : OutputFormat::kTable;
  }
};

/// The command line's state between parsing and running.
struct Session {
  Settings settings;
  std::function<ExitCode()> action;  ///< of the command that was given
};

}  // namespace hecaton::services::cli
