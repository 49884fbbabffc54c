#pragma once
/// The command line that all services share.

#include <optional>
#include <string>

#include "services/runtime/exit_code.hpp"

namespace CLI {
class App;
}

namespace hecaton::services {

inline constexpr int kHighestDomain = 199;  ///< beyond, the ports of many participants leave the range of 16 bits

enum class LogLevel { kDebug, kInfo, kWarning, kError };

struct ServiceOptions {
  std::string cell;           ///< path of the cell file
  std::string arm;            ///< which arm it serves; empty for services of the whole cell
  std::optional<int> domain;  ///< DDS domain 0 to 199; otherwise HECATON_DOMAIN, otherwise the cell file's
  std::string host;           ///< the cell's host it runs on; empty: where the cell file places it
  std::string sources;        ///< folder with copies of the files to be read; empty: they are read where they are
  std::string memory;         ///< file in which survives what must; empty: nothing does
  int alive_fd = -1;          ///< a descriptor on which its agent waits for signs of life; −1: nobody waits
  int life_fd = -1;           ///< one whose end tells its agent that it ends (life_line.hpp); −1: nobody waits
  LogLevel log_level = LogLevel::kInfo;
  std::string log_file;  ///< empty: stderr
};

/// Adds --domain, --host, --log-level and --log-file to any command.
void add_common_options(CLI::App& app, ServiceOptions& options);

/// Parses; the exit code to leave with when there is nothing to run: --help, --version, or what was wrong and is
/// explained on stderr.
[[nodiscard]] std::optional<ExitCode> parse_or_explain(CLI::App& app, int argc, const char* const* argv);

enum class Subject {
  kCell,  ///< the whole cell
  kArm,   ///< one arm
};

/// CELL [--arm NAME], with --memory FILE, and the common options, as parse_or_explain does it.
[[nodiscard]] std::optional<ExitCode> parse_options(int argc, const char* const* argv, const std::string& description,
                                                    Subject subject, ServiceOptions& options);

/// The DDS domain: option, else HECATON_DOMAIN, else `of_cell`. Throws std::runtime_error with a sentence when
/// HECATON_DOMAIN is no number from 0 to 199.
[[nodiscard]] int choose_domain(const ServiceOptions& options, int of_cell);

}  // namespace hecaton::services
